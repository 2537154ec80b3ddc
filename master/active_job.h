#pragma once

#include "master/job.h"
#include "master/ledger.h"
#include "master/staged_result.h"

#include <cstdint>
#include <memory>
#include <string>

/// A running job: the ledger and the sums. Results go in, a solution comes out.
namespace lumenfarm {

struct Outcome {
    wire::Verdict verdict = wire::Verdict::accepted;
    std::string sentence;  ///< for the worker, unless accepted
};

class ActiveJob {
public:
    ActiveJob(const JobSpec& spec, std::shared_ptr<const PreparedJob> prepared);

    Ledger& ledger() { return ledger_; }
    const Ledger& ledger() const { return ledger_; }
    const PreparedJob& prepared() const { return *prepared_; }
    Packing packing() const { return packing_; }
    const EnergyBalance& balance() const { return balance_; }
    double trace_s() const { return time_.trace_s; }

    /// Merges the result whole, or not at all. What it covered and was refused is given out again.
    Outcome commit(WorkerId worker, const StagedResult& result, const wire::ResultDone& done);
    /// Hits above this are not kept any more.
    std::uint64_t keep_threshold() const { return kept_.threshold(); }

    /// The sums so far as a solution; this job is empty afterwards.
    std::shared_ptr<const Solution> take_solution(const Digest& scene, std::uint32_t workers, double total_s);

private:
    void merge(const wire::ResultHits& part);
    void merge(const wire::ResultMap& part);

    JobSpec spec_;
    std::shared_ptr<const PreparedJob> prepared_;
    Packing packing_;
    Ledger ledger_;
    LightMap sums_;
    KeptHits kept_;
    EnergyBalance balance_;
    SolutionTime time_;
};

}  // namespace lumenfarm
