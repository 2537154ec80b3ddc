#pragma once

#include "common/service/pulse.h"
#include "common/support/limits.h"
#include "common/support/result.h"
#include "worker/slot.h"

#include <boost/asio/io_context.hpp>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/// The worker as a running thing: WorkerCore behind a connection that it keeps trying to have, one tracing thread a
/// slot. lumenfarm-worker is one of these and a signal handler; `lumenfarm run` embeds some. Logs go to spdlog's
/// default logger.
namespace lumenfarm {

/// `loop`: from which the slot is commanded, and which outlives it.
using SlotMaker =
    std::function<std::unique_ptr<worker::Slot>(boost::asio::io_context& loop, worker::OnReport on_report)>;

struct WorkerOptions {
    std::string master = "127.0.0.1:7420";  ///< HOST:PORT
    std::uint32_t threads = 0;              ///< tracing threads; 0 is one for each core
    std::filesystem::path cache;            ///< of scenes; empty: worker::default_cache_folder()
    std::uint64_t cache_bytes_max = std::uint64_t{20} << 30;
    std::uint64_t memory_limit_bytes = 0;          ///< 0: three quarters of the machine's
    bool parts_only = false;                       ///< strategy subspaces: never a scene as a whole
    std::string name;                              ///< empty: the machine's
    std::string isa;                               ///< Embree ISA; empty: the best of this machine
    bool idle_priority = true;                     ///< tracing threads yield to everything else on the machine
    double drain_seconds = limits::drain_seconds;  ///< from drain() to the end, at most
    std::uint64_t fingerprint = 0;                 ///< of what it traces; 0: transport_fingerprint(isa)
    JobMaker make_job = {};                        ///< empty: tracing_jobs(isa)
    SlotMaker make_slot = {};                      ///< empty: a thread each
};

class WorkerClient {
public:
    /// Starts its threads and returns at once; the master need not be there yet. Errors: bad_input (address, threads,
    /// ISA), failed (Embree).
    static Result<std::unique_ptr<WorkerClient>> start(const WorkerOptions& options);
    ~WorkerClient();  ///< ends without waiting for results

    // Any thread may call these.

    /// Hands over what is done and returns the rest of its leases; wait() returns within the drain time and
    /// limits::goodbye_seconds.
    void drain();
    /// Returns its leases without waiting for what is done.
    void end_now();
    /// Until the worker has drained and said goodbye, or the master refuses it. Threads may still be in the midst of a
    /// slice, or of a scene. Errors: failed, with the master's sentence.
    Result<void> wait();
    bool ended() const;                      ///< wait() would return at once
    bool connected() const;                  ///< and welcome
    std::uint64_t particles_merged() const;  ///< that the master has acknowledged

    /// The threads that serve. REQUIRES: none is asked after this is gone.
    std::vector<ServingThread> threads();
    /// What the worker does, in one line. Never waits.
    std::string summary() const;

private:
    class Running;
    explicit WorkerClient(std::unique_ptr<Running> running);
    std::unique_ptr<Running> running_;
};

}  // namespace lumenfarm
