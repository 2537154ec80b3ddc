#pragma once

#include "common/scene/job_spec.h"
#include "common/support/digest.h"
#include "common/support/result.h"
#include "proto/messages_client.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// How fast a farm of real processes on this machine is: one master, relays if there are to be some, and workers that
/// pull from them over loopback.
namespace lumenfarm {

/// Paced workers (worker/paced): each stands for a computer, and has its results beforehand.
struct PacedBench {
    static constexpr double slowness = 10;

    double particles_per_s = 0;  ///< of each thread
    std::uint32_t slow = 0;      ///< so many of the workers are so many times slower
    std::uint32_t stopped = 0;   ///< so many stop in the middle, and do not say so
    std::string scene_file, stored_file;
};

struct FarmBenchOptions {
    std::vector<std::uint32_t> workers;           ///< numbers of them to compare
    std::vector<std::uint64_t> particles;         ///< of the jobs
    std::vector<std::uint32_t> hits_per_message;  ///< to compare; empty: that of the job
    std::uint32_t relays = 0;                     ///< between the master and all workers, which they share
    std::uint32_t threads = 1;                    ///< of a worker
    std::uint32_t runs = 5;                       ///< of each
    std::string isa;                              ///< of the workers' ray queries; empty: the best
    std::uint64_t memory_limit_bytes = 0;         ///< of a worker; 0: its default
    bool parts_only = false;                      ///< strategy subspaces: no worker takes the scene whole
    std::uint32_t jobs = 1;                       ///< in a run, all alike, submitted together
    double set_seconds = 0;                       ///< of masters and relays; 0: their default
    double flush_seconds = 0;                     ///< the same
    std::uint32_t results_in_flight = 0;          ///< the same
    bool compress = false;                        ///< of masters and relays
    std::optional<PacedBench> paced;              ///< in place of workers that trace
    JobSpec job;                                  ///< but for the particles
};

/// A job, or some, on a farm that had just started, so that it needs the scene, too. Sums are over all jobs.
struct FarmRun {
    std::uint32_t run = 0;  ///< from 1 on
    std::uint32_t workers = 0;
    std::uint64_t particles = 0;  ///< of a job
    std::uint32_t jobs = 1;
    std::uint32_t hits_per_message = 0;
    Packing packing = Packing::automatic;  ///< in force
    double ideal_s = 0;                    ///< paced workers: what their paces allow; else 0
    double total_s = 0;                    ///< from the submission until the result is stored
    double trace_s = 0;                    ///< processor time that a thread spent tracing, on average
    double master_cpu_s = 0;               ///< meanwhile
    std::uint32_t relays = 0;
    double relay_cpu_s = 0;   ///< of all relays
    double worker_cpu_s = 0;  ///< of all workers; paced workers: that they stand for
    std::uint64_t hits = 0;
    wire::Traffic traffic;  ///< between the master and workers or relays, the scene included
    Digest digest;
};

/// Every combination `runs` times, taken in turn, so that what else the machine does meets all alike. Folders and logs
/// of the daemons are made in `folder`. `on_run` is told of each. Errors: failed (a daemon, or two digests of one job
/// differ), bad_input (the job is refused).
Result<std::vector<FarmRun>> bench_farm(const FarmBenchOptions& options, std::span<const std::byte> scene_bytes,
                                        const std::filesystem::path& folder,
                                        const std::function<void(const FarmRun&)>& on_run);

/// The median of what was measured alike, and how it compares with the fewest workers for that job.
struct FarmBenchRow {
    std::uint32_t workers = 0;
    std::uint64_t particles = 0;
    std::uint32_t hits_per_message = 0;
    double total_s = 0;
    double trace_s = 0;
    double speed_up_total = 0;  ///< times the fewest workers; paced workers: over what one of them would take
    double speed_up_trace = 0;  ///< the same of pure tracing time
    double efficiency = 0;      ///< speed_up_total / workers; paced workers: the ideal time over the total time
    double particles_per_s = 0;
    double bytes_per_particle = 0;  ///< both ways
    double master_cpu_per_worker_cpu = 0;
    Packing packing = Packing::automatic;
};
/// In the order of the runs.
std::vector<FarmBenchRow> rows_of(std::span<const FarmRun> runs);

}  // namespace lumenfarm
