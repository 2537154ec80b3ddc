#pragma once

#include "common/solution/solution.h"
#include "common/support/result.h"
#include "master/flight_queues.h"
#include "master/job_sums.h"

#include <cstddef>
#include <span>
#include <vector>

/// What a running job has, to go on from: a solution, and behind it (strategy subspaces) what is in flight
/// (docs/segment_file.md). A solution alone is one, too.
namespace lumenfarm {

struct JobSnapshot {
    Solution solution;  ///< what is in flight is booked as cut off
    Partition cut;      ///< in subspaces; empty: as the job is prepared
    WorkTimes work_times;
    FlightQueues flights;
    std::vector<IntervalSet> ended;  ///< flights, by subspace
};

/// `solution`: its bytes. `cut`: that the flights are filed by, and the times are of.
std::vector<std::byte> encode_snapshot(std::vector<std::byte> solution, const Partition& cut,
                                       const WorkTimes& work_times, const FlightQueues& flights,
                                       const std::vector<IntervalSet>& ended);
/// Reads foreign bytes. Errors: bad_input.
Result<JobSnapshot> decode_snapshot(std::span<const std::byte> bytes, const PreparedJob& prepared, const Digest& scene);

}  // namespace lumenfarm
