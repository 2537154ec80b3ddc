#pragma once

#include "worker/effects.h"
#include "worker/lease_returns.h"
#include "worker/part_shelf.h"
#include "worker/result_outbox.h"
#include "worker/scene_fetch.h"

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// The worker without sockets, clocks, threads and disks (law 7): events go in, effects come out. Times are seconds of
/// one steady clock of the caller's.
namespace lumenfarm::worker {

struct WorkerIdentity {
    std::string name;
    std::uint64_t instance = 0;      ///< random, of this process
    std::uint32_t threads = 1;       ///< slots
    std::uint64_t memory_bytes = 0;  ///< that it may take; 0: no limit
    bool parts_only = false;         ///< subspaces: never the scene as a whole
    std::string isa;
    std::uint64_t fingerprint = 0;
};

class WorkerCore {
public:
    explicit WorkerCore(const WorkerIdentity& identity, double drain_seconds = limits::drain_seconds);

    /// The connection is there: says Hello.
    Effects on_connect(double now_s);
    Effects on_message(wire::Message message, double now_s);
    /// The connection is lost; tracing goes on. `goodbye`: the master's, if it said one.
    Effects on_disconnect(const std::optional<wire::Goodbye>& goodbye, double now_s);
    /// Something was discarded by the shell.
    Effects on_discarded(Discard reason, std::string sentence, double now_s);
    /// REQUIRES: called at least once a second.
    Effects tick(double now_s);

    /// The next part of a result, to be asked for while the connection has room.
    std::optional<wire::Message> next_bulk();

    Effects on_slot(std::size_t slot, SlotReport report, double now_s);
    /// Null: not in the cache, or damaged there.
    Effects on_scene_loaded(const Digest& scene, std::shared_ptr<const std::vector<std::byte>> bytes, double now_s);
    /// `file`: of the PreparePart.
    Effects on_part_prepared(const PartKey& key, const Digest& file, Result<Piece> prepared, double now_s);
    /// `info`: of the PrepareJob.
    Effects on_job_prepared(const wire::JobInfo& info, Result<std::shared_ptr<const JobContext>> prepared,
                            double now_s);

    /// Pull no more, hand over what is done, return the rest. Finished comes within the drain time, with
    /// whatever could not be handed over until then.
    Effects drain(double now_s);
    /// As drain(), and Finished comes at once.
    Effects end_now(double now_s);

    bool welcome() const { return welcome_; }
    /// What the worker does now, in one line for people.
    std::string summary() const;
    std::uint64_t particles_merged() const { return particles_merged_; }
    std::size_t results_held() const { return results_.size(); }
    /// A bound that is broken. Nothing when all is well; for tests.
    std::optional<std::string> contradiction() const;
    WorkerCounts& counts() { return counts_; }  ///< the shell counts closes
    const WorkerCounts& counts() const { return counts_; }

private:
    struct Slot {
        std::optional<wire::Lease> lease;                    ///< of the set, until it is finished
        JobId job = 0;                                       ///< of the set and of the open result
        std::uint64_t audit = 0;                             ///< of the open result
        bool apart = false;                                  ///< the open result is of one set alone
        std::map<std::uint64_t, std::uint32_t> open_leases;  ///< that the open result covers, and their epochs
        bool running = false;                                ///< a report is due
        bool open = false;                                   ///< a result is open
        bool abandoned = false;                              ///< what it holds is to be thrown away
        bool close_asked = false;  ///< of the running slot, which drops it when it has just stopped
        double open_since_s = 0;
    };
    struct Job {
        wire::JobInfo info;
        std::shared_ptr<const JobContext> context;  ///< once made, the only one: sums of one don't fit another
        bool loading = false;                       ///< its scene is looked for in the cache
        bool missing = false;                       ///< and is not there
        bool preparing = false;                     ///< its context is being made
        bool failed = false;
        bool draining = false;
        bool confirmed = false;       ///< the master has told of it in this session
        bool has_results = false;     ///< at least one was closed
        bool gives_parts_up = false;  ///< the log says so

        /// Most time that sums wait. The first result comes soon, for the master to learn the worker's speed.
        double flush_s() const {
            return has_results ? info.flush_seconds : std::min(limits::first_flush_seconds, info.flush_seconds);
        }
    };
    /// A subspace whose triangles are on their way.
    struct Bringing {
        PartKey key;
        PartFile file;
        bool missing = false;    ///< in the cache: it is fetched
        bool preparing = false;  ///< its bytes are here
    };

    // jobs and scenes (worker_jobs.cpp)
    void take_job(const wire::JobInfo& info);
    void take_lease(const wire::Lease& lease);
    void drop_job(JobId job);
    void drop_jobs_not_held();
    void drain_job(JobId job);
    void fail_job(JobId job, wire::ReturnReason reason);
    void fetch_next();
    void take_requests(const Result<std::vector<wire::Message>>& requests);
    void fail_fetch(const std::string& why);
    void prepare_jobs_of(const Digest& scene, const std::shared_ptr<const std::vector<std::byte>>& bytes);
    void take_context(Job& job, std::shared_ptr<const JobContext> context);
    bool ready(JobId job) const;
    bool ready(const wire::Lease& lease) const { return ready(lease.job) && is_at_hand(lease); }
    bool draining(JobId job) const;

    // subspaces (worker_parts.cpp)
    bool has_subspaces(JobId job) const;
    std::optional<PartKey> part_of(const wire::Lease& lease) const;
    std::optional<PartKey> piece_for(const wire::Lease& lease) const;
    bool is_at_hand(const wire::Lease& lease) const;
    bool is_possible(const wire::Lease& lease) const;
    Result<void> open_parts(const Job& job);
    void bring_next();
    void give_up(const PartKey& key);
    void fail_bringing(wire::ReturnReason reason);
    void prepare_part_of(const Digest& file, const std::shared_ptr<const std::vector<std::byte>>& bytes);
    void tell_parts();
    void tell_parts(JobId job);
    void close_parts(JobId job);

    // sets and slots (worker_slots.cpp)
    void feed(std::size_t index, double now_s);
    void start_next(std::size_t index, double now_s);
    void take_report(Slot& slot, SlotReport& report);
    void stop_slot(std::size_t index, SlotAsk ask);
    void interrupt_late(double now_s);
    void return_queued(JobId only);
    void leave_refused(const Parcel& refused);
    bool idle() const;

    // results and the session (worker_core.cpp)
    void greet(const wire::Welcome& welcome, double now_s);
    void take_ack(const wire::ResultAck& ack);
    void send_returns();
    void count(Discard reason, std::uint64_t times, std::string sentence);
    void ignore(const wire::Message& message);
    void pull();
    void begin_drain(double now_s);
    void finish_if_drained(double now_s);
    std::vector<wire::LeaseProgress> leases_held() const;
    bool room_for_results() const {
        return results_.size() < slots_.size() + credit_ &&
               results_.bytes() < limits::result_bytes_in_flight + slots_.size() * limits::result_close_bytes;
    }
    void send(wire::Message message) { effects_.push_back(Send{std::move(message)}); }
    Effects settle_and_take(double now_s);

    WorkerIdentity identity_;
    double drain_seconds_;
    bool welcome_ = false;
    std::optional<double> lost_s_;  ///< since when there is no connection
    std::vector<Slot> slots_;
    std::deque<wire::Lease> queue_;  ///< sets that wait for a slot
    std::map<JobId, Job> jobs_;
    PartShelf shelf_;
    std::optional<Bringing> bringing_;
    bool making_room_ = false;  ///< no set of a subspace begins until something is given up
    std::uint64_t parts_brought_ = 0;
    std::optional<SceneFetch> fetch_;
    ResultOutbox results_;  ///< not acknowledged yet
    LeaseReturns returns_;
    std::uint32_t wished_ = 0;                          ///< what the master believes that this worker has room for
    std::uint64_t leases_received_ = 0;                 ///< in this session
    std::uint32_t credit_ = limits::results_in_flight;  ///< results that may be under way; the master's
    std::uint32_t largest_credit_ = credit_;            ///< of all sessions
    std::optional<double> drain_by_s_;
    bool finished_ = false;
    std::uint64_t particles_merged_ = 0;
    WorkerCounts counts_;
    Effects effects_;
};

}  // namespace lumenfarm::worker
