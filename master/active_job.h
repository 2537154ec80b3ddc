#pragma once

#include "master/flight_queues.h"
#include "master/ledger.h"
#include "master/recovered_job.h"
#include "master/staged_result.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// A running job as the core sees it: who has what, and what is done. The sums are with the storage (job_log.h).
namespace lumenfarm {

struct Outcome {
    wire::Verdict verdict = wire::Verdict::accepted;
    std::string sentence;  ///< for the worker, unless accepted
};

class ActiveJob {
public:
    /// Leases of an earlier life are current until `deadline_s`.
    ActiveJob(const JobSpec& spec, RecoveredJob recovered, double now_s, double deadline_s);

    /// What workers fetch first.
    const WorkerFiles& files() const { return files_; }
    Ledger& ledger() { return ledger_; }
    const Ledger& ledger() const { return ledger_; }
    const PreparedJob& prepared() const { return *prepared_; }
    Packing packing() const { return packing_; }
    const EnergyBalance& balance() const { return balance_; }
    double trace_cpu_s() const { return trace_cpu_s_; }
    const JobEffort& earlier_effort() const { return earlier_effort_; }  ///< in earlier lives of the master

    /// What becomes of a result that has come whole: accepted, and its particles are taken to be stored; or refused,
    /// and what its leases owe is given out again; or nothing, since some of its particles are being stored already.
    std::optional<Outcome> take(WorkerId worker, StagedResult& result, wire::ResultDone done);
    /// The worker forgets a whole result: what its leases still owe is given out again.
    void take_back(WorkerId worker, std::span<const Claim> claims);
    void retract(Retracted left);

    // A relay's job, of which nothing is there but what a master above lends
    bool may_lend(const ParticleRange& range) const;
    /// `flights`: those of a subspace's range; none of a light's. REQUIRES: may_lend().
    void lend(const ParticleRange& range, FlightQueues::Flights flights);
    /// What of it has not arrived is nobody's any more.
    void withdraw(const ParticleRange& range);
    /// Particles that were filed in subspaces.
    void file(const FlightQueues::Filed& filed);
    /// The result lasts. REQUIRES: what it brought for other subspaces was filed.
    void commit(const StagedResult& result);
    /// The particles of a range that wait in a subspace; none of a light.
    FlightQueues::Flights flights(const ParticleRange& range) const;

    /// Hits above this are not kept any more.
    std::uint64_t keep_threshold() const { return keep_threshold_; }
    void set_keep_threshold(std::uint64_t threshold) { keep_threshold_ = threshold; }

private:
    std::shared_ptr<const PreparedJob> prepared_;
    WorkerFiles files_;
    Packing packing_;
    FlightQueues flights_;
    Ledger ledger_;
    EnergyBalance balance_;
    double trace_cpu_s_;
    JobEffort earlier_effort_;
    std::uint64_t keep_threshold_;
};

/// What a result says that it covers.
std::vector<Claim> claims_of(const wire::ResultDone& done);

}  // namespace lumenfarm
