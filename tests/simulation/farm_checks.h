#pragma once

#include "master/master_core.h"
#include "master/storage.h"
#include "tests/simulation/world.h"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// What must hold in every farm at every step, kept in books of its own beside the master's:
///
/// - a particle is acknowledged once, is committed by then, and is so in every later life of the master;
/// - acknowledged particles are never leased again;
/// - every particle is free, leased, being stored or committed (Ledger::contradiction());
/// - what the master and the workers hold is within limits.h (contradiction() of both);
/// - no lease expires while its worker is there, nor is an honest result called impossible;
/// - a key is one job; a job that was promised stays, and so does its end once it was told.
namespace lumenfarm::testing {

/// Particles of lights and in flight.
std::uint64_t committed_in_all(const Ledger& ledger);

class FarmChecks {
public:
    /// `jobs`: how many will be submitted; they get the numbers from 1 on.
    FarmChecks(World& world, std::size_t jobs) : world_(world), jobs_(jobs) {}

    void violated(std::string sentence);
    /// A sentence each. The farm stops at the first.
    const std::vector<std::string>& violations() const { return violations_; }

    /// A worker has sent a whole result.
    void on_offer(WorkerId worker, const wire::ResultDone& done) {
        offers_[{worker, done.result}] = {done.job, done.claims};
    }

    void on_master_start(const Storage::Start& start);
    void on_master_end();
    void on_recovered(const JobRecord& record, const RecoveredJob& recovered);
    /// What liars have traced is not believed any more, and may be leased again.
    void on_retracted(const Retract& retract, const Retracted& left);
    void somebody_lies() { somebody_lies_ = true; }
    /// The master knows what the worker holds.
    void on_leases_stated(WorkerId worker) { present_.insert(worker); }
    /// The master knows that the worker's session has ended.
    void on_worker_left(WorkerId worker) { present_.erase(worker); }
    /// A client wants the job to go on though it may be over.
    void on_extension_asked(JobId job) {
        ends_.erase(job);
        cancelled_.erase(job);
    }
    /// The master says so to a worker or a client, of which `to` is the instance.
    void on_sent(const MasterCore& core, std::uint64_t to, const wire::Message& message);
    void before_tick(const MasterCore& core);
    void after_tick(const MasterCore& core);
    void after_event(const MasterCore& core);

    /// How often subspaces were cut anew.
    std::uint64_t recuts() const { return recuts_; }
    /// By source.
    const std::vector<IntervalSet>& acknowledged(JobId job) { return acknowledged_[job]; }
    std::optional<JobId> job_of(std::uint64_t client) const;
    /// A process of a worker asks for a file once when its cache lacks it, and once more in each session at most.
    void on_files_asked(std::uint64_t times, std::uint64_t sessions_and_files_missed) {
        if (times > sessions_and_files_missed) violated("a worker asks for a file again and again");
    }

private:
    struct Offer {
        JobId job = 0;
        std::vector<wire::Claim> claims;
    };
    struct HeldLease {
        JobId job = 0;
        LeaseId lease = 0;
        WorkerId worker = 0;
    };
    struct End {
        wire::JobState state = wire::JobState::done;
        std::optional<Digest> digest;
        bool operator==(const End&) const = default;
    };

    void on_lease(const wire::Lease& lease);
    void on_ack(const MasterCore& core, WorkerId worker, const wire::ResultAck& ack);
    void on_promise(std::uint64_t client, JobId job);
    void on_status(const wire::JobStatus& status);
    IntervalSet& acknowledged(JobId job, std::uint32_t light);

    World& world_;
    std::size_t jobs_;
    std::vector<std::string> violations_;
    std::map<std::pair<WorkerId, std::uint64_t>, Offer> offers_;  ///< by worker and its number of the result
    std::map<JobId, std::vector<IntervalSet>> acknowledged_;
    std::map<std::uint64_t, JobId> promised_;  ///< by client
    std::set<JobId> cancelled_;
    std::set<LeaseId> audit_leases_;
    bool somebody_lies_ = false;
    std::map<JobId, End> ends_;
    std::set<WorkerId> present_;
    std::vector<HeldLease> held_;  ///< before the tick, by workers that are present
    std::uint64_t expired_ = 0;    ///< before the tick
    std::map<JobId, std::uint64_t> committed_;
    std::map<JobId, Digest> plans_;  ///< or scenes
    std::uint64_t recuts_ = 0;
};

}  // namespace lumenfarm::testing
