#pragma once

#include "common/solution/cut_learning.h"
#include "master/flight_queues.h"
#include "master/job.h"
#include "master/staged_result.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

/// What the committed results of a job add up to. Integers: the order does not matter (law 3).
namespace lumenfarm {

class JobSums {
public:
    JobSums(const JobSpec& spec, std::shared_ptr<const PreparedJob> prepared);

    /// Whether the particles that the result covers are the job's, once each, and not merged yet (law 4), and its
    /// balance closes with what its flights brought in (law 5).
    bool fits(const StagedResult& result) const;
    /// Gives what was filed in subspaces. REQUIRES: the result is complete, and fits.
    std::vector<FlightQueues::Filed> merge(const StagedResult& result);

    /// Everything so far as a solution, in which what is in flight is booked as cut off; this is of no use until
    /// restore().
    Solution take(const Digest& scene);
    /// Goes on from a solution of this job, whole or not, what is in flight, and work_times(). REQUIRES: it was made by
    /// take() or decoded with the scene.
    void restore(Solution solution);
    void restore(Solution solution, FlightQueues flights, std::vector<IntervalSet> ended, WorkTimes work_times);

    /// Files what is in flight anew, by another cut in as many subspaces, and numbers it from 0. `lesson`: of the cut
    /// so far.
    void file_by(const Partition& cut, std::optional<CutLesson> lesson);

    const LightMap& sums() const { return sums_; }
    const PreparedJob& prepared() const { return *prepared_; }
    const std::vector<IntervalSet>& committed() const { return committed_; }  ///< by light
    const FlightQueues& flights() const { return flights_; }
    const std::vector<IntervalSet>& ended() const { return ended_; }  ///< flights, by subspace
    const EnergyBalance& balance() const { return balance_; }
    const SolutionTime& time() const { return time_; }
    /// Hits of a higher priority are not kept any more.
    std::uint64_t keep_threshold() const { return kept_.threshold(); }
    /// What following particles took, as results say.
    const WorkTimes& work_times() const { return work_times_; }
    std::uint64_t bytes() const;  ///< in memory; a snapshot has no more than about those

private:
    void merge(const wire::ResultHits& part);
    void merge(const wire::ResultMap& part);
    void merge(const wire::ResultKept& part);
    void merge(const wire::ResultWork& part);
    void merge(const wire::ResultDone& done);
    bool is_there(const ParticleRange& range) const;
    IntervalSet& done(std::uint32_t source) {
        return source < committed_.size() ? committed_[source] : ended_[source - committed_.size()];
    }
    const IntervalSet& done(std::uint32_t source) const { return const_cast<JobSums*>(this)->done(source); }

    JobSpec spec_;
    std::shared_ptr<const PreparedJob> prepared_;
    LightMap sums_;
    KeptHits kept_;
    std::vector<IntervalSet> committed_;
    FlightQueues flights_;
    std::vector<IntervalSet> ended_;
    WorkTimes work_times_;
    EnergyBalance balance_;
    SolutionTime time_;
};

}  // namespace lumenfarm
