#pragma once

#include "common/solution/cut_learning.h"
#include "common/solution/interval_set.h"
#include "common/transport/scene_plan.h"
#include "master/flight_queues.h"
#include "master/job.h"
#include "master/job_store.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// What the core learns of a job from the disk.
namespace lumenfarm {

/// How long a job has taken, and by how many workers.
struct JobEffort {
    double elapsed_s = 0;
    std::uint32_t workers = 0;
};

/// What the merging of results did to a job.
struct Merged {
    std::uint64_t keep_threshold = 0;
    std::vector<FlightQueues::Filed> filed;  ///< in subspaces, in order
};

/// What is left of a job after results were retracted.
struct Retracted {
    std::vector<IntervalSet> committed;  ///< by light
    EnergyBalance balance;
    double trace_cpu_s = 0;  ///< processor time in the tracer, summed over threads
    std::uint64_t keep_threshold = 0;
};

/// What workers of a job fetch first: the scene, or its plan, whose parts follow (scene_plan.h).
struct WorkerFiles {
    Digest first;
    std::uint64_t first_bytes = 0;
    std::vector<PartFile> parts;  ///< by subspace
};

/// A job that may begin, or go on where an earlier life of the master left it.
struct RecoveredJob {
    std::shared_ptr<const PreparedJob> prepared;
    WorkerFiles files;
    std::vector<IntervalSet> committed;  ///< by source
    FlightQueues flights;
    EnergyBalance balance;
    double trace_cpu_s = 0;  ///< processor time in the tracer, summed over threads
    JobEffort effort;
    std::uint64_t keep_threshold = 0;
    std::vector<GivenLease> leases;
    std::vector<std::string> damages;  ///< what was lost, one sentence each; its particles are traced again
    std::optional<Evenness> recut;     ///< it was cut in subspaces anew, and what is in flight has new numbers
};

}  // namespace lumenfarm
