#pragma once

#include "master/job.h"
#include "master/staged_result.h"

#include <cstdint>
#include <memory>
#include <vector>

/// What the committed results of a job add up to. Integers: the order does not matter (law 3).
namespace lumenfarm {

class JobSums {
public:
    JobSums(const JobSpec& spec, std::shared_ptr<const PreparedJob> prepared);

    /// Whether the particles that the result covers are the job's, once each, and not merged yet (law 4).
    bool fits(const StagedResult& result) const;
    /// REQUIRES: the result is complete, and fits.
    void merge(const StagedResult& result);

    /// Everything so far as a solution; this is of no use until restore().
    Solution take(const Digest& scene);
    /// Goes on from a solution of this job, whole or not. REQUIRES: it was made by take() or decoded with the scene.
    void restore(Solution solution);

    const PreparedJob& prepared() const { return *prepared_; }
    const std::shared_ptr<const PreparedJob>& prepared_job() const { return prepared_; }
    const std::vector<IntervalSet>& committed() const { return committed_; }
    const EnergyBalance& balance() const { return balance_; }
    const SolutionTime& time() const { return time_; }
    /// Hits of a higher priority are not kept any more.
    std::uint64_t keep_threshold() const { return kept_.threshold(); }
    std::uint64_t bytes() const;  ///< in memory; about those of a solution

private:
    void merge(const wire::ResultHits& part);
    void merge(const wire::ResultMap& part);
    void merge(const wire::ResultKept& part);
    void merge(const wire::ResultDone& done);

    JobSpec spec_;
    std::shared_ptr<const PreparedJob> prepared_;
    LightMap sums_;
    KeptHits kept_;
    std::vector<IntervalSet> committed_;
    EnergyBalance balance_;
    SolutionTime time_;
};

}  // namespace lumenfarm
