#pragma once

#include "common/service/pulse.h"
#include "common/support/result.h"
#include "master/effects.h"
#include "master/serving_options.h"
#include "proto/messages.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// The master as a running thing: MasterCore behind a listener, with its storage on disk. lumenfarm-master is one of
/// these and a signal handler; `lumenfarm run` embeds one. Logs go to spdlog's default logger.
///
///   MasterOptions options;
///   options.listen = "127.0.0.1:0";
///   options.storage = folder;
///   auto master = MasterServer::start(options);
///   auto job = (*master)->submit(spec, scene_bytes);
///   while (auto status = (*master)->wait(*job, 0.5)) ...          // status->state; or cancel(*job) and wait on
///   auto files = (*master)->files(*job);                          // solution and scene, to be copied
namespace lumenfarm {

struct MasterOptions : ServingOptions {
    double checkpoint_seconds = 10;
    double recut_above = 0;        ///< subspaces that share the work out less evenly are cut anew; 0: never
    double audit_fraction = 0;     ///< of the results are traced again by a second worker
    double keep_days = 0;          ///< jobs that ended longer ago are removed; 0 keeps them
    std::uint64_t keep_bytes = 0;  ///< of solutions, beyond which the job that ended first is removed; 0: any number
};

/// Where the files of a job are that is over.
struct JobFiles {
    std::filesystem::path scene;
    std::filesystem::path solution;
    bool complete = false;
};

class MasterServer {
public:
    /// Opens the storage, goes on with the jobs of an earlier life, listens. Errors: bad_input (address; not loopback
    /// without allow_plaintext), failed (port busy, storage unwritable or in use by another master).
    static Result<std::unique_ptr<MasterServer>> start(const MasterOptions& options);
    ~MasterServer();  ///< stop()

    std::uint16_t port() const;
    const std::string& address() const;  ///< "ADDRESS:PORT"

    // Any thread may call these; each waits for the master's thread.

    /// Errors: bad_input (job or scene refused), failed (disk).
    Result<JobId> submit(const JobSpec& spec, std::span<const std::byte> scene_bytes);
    /// Errors: bad_input, no such job.
    Result<wire::JobStatus> status(JobId job) const;
    /// Waits until the job is over, at most `seconds`, and gives its status.
    Result<wire::JobStatus> wait(JobId job, double seconds) const;
    /// Ends the job and keeps what was done; wait() tells when that is stored (state cancelled, or done).
    void cancel(JobId job);
    std::vector<wire::WorkerStatus> workers() const;
    /// Errors: bad_input (no such job), failed (not over, or it ended without a result: says why).
    Result<JobFiles> files(JobId job) const;

    /// Why the master can't go on, once that is so: its disk failed. It is to be stopped; the next life recovers.
    std::optional<Error> failure() const;
    /// No more leases; results on their way are stored and answered, at most limits::stop_seconds; a Goodbye to
    /// everyone; a snapshot of each running job, however long that takes. The next life goes on with unfinished jobs.
    void stop();

    /// The threads that serve, also while it stops. REQUIRES: none is asked after this is gone.
    std::vector<ServingThread> threads();
    /// What the master does, in one line. Never waits.
    std::string summary() const;

private:
    class Running;
    explicit MasterServer(std::unique_ptr<Running> running);
    std::unique_ptr<Running> running_;
};

}  // namespace lumenfarm
