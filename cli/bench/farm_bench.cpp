#include "cli/bench/farm_bench.h"

#include "cli/bench/farm_processes.h"
#include "cli/bench/median.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace lumenfarm {

namespace {

Result<FarmRun> run_once(const FarmBenchOptions& options, std::uint32_t workers, const JobSpec& job,
                         std::span<const std::byte> scene_bytes, const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return failed("'" + folder.string() + "' can't be made: " + error.message());
    Result<FarmRun> run = [&]() -> Result<FarmRun> {
        const auto farm = FarmProcesses::start(options, workers, job, folder);
        return farm ? (*farm)->run(scene_bytes) : farm.error();
    }();
    std::filesystem::remove_all(folder, error);
    return run;
}

FarmBenchRow row_of(const std::vector<const FarmRun*>& runs) {
    const auto median_of = [&](auto value) {
        std::vector<double> values;
        for (const FarmRun* run : runs) values.push_back(value(*run));
        return median(std::move(values));
    };
    FarmBenchRow row;
    row.workers = runs.front()->workers;
    row.particles = runs.front()->particles;
    row.hits_per_message = runs.front()->hits_per_message;
    row.packing = runs.front()->packing;
    row.total_s = median_of([](const FarmRun& run) { return run.total_s; });
    row.trace_s = median_of([](const FarmRun& run) { return run.trace_s; });
    const auto particles = static_cast<double>(row.particles) * runs.front()->jobs;
    row.particles_per_s = particles / row.total_s;
    row.bytes_per_particle = median_of([&](const FarmRun& run) {
        return static_cast<double>(run.traffic.bytes_in + run.traffic.bytes_out) / particles;
    });
    row.master_cpu_per_worker_cpu =
        median_of([](const FarmRun& run) { return run.worker_cpu_s > 0 ? run.master_cpu_s / run.worker_cpu_s : 0; });
    if (runs.front()->ideal_s > 0) row.efficiency = runs.front()->ideal_s / row.total_s;  // of paced workers
    return row;
}

}  // namespace

Result<std::vector<FarmRun>> bench_farm(const FarmBenchOptions& options, std::span<const std::byte> scene_bytes,
                                        const std::filesystem::path& folder,
                                        const std::function<void(const FarmRun&)>& on_run) {
    std::vector<std::uint32_t> granularities = options.hits_per_message;
    if (granularities.empty()) granularities.push_back(options.job.hits_per_message);
    std::map<std::uint64_t, Digest> digests;
    std::vector<FarmRun> runs;
    for (std::uint32_t round = 1; round <= options.runs; ++round)
        for (const std::uint64_t particles : options.particles)
            for (const std::uint32_t granularity : granularities)
                for (const std::uint32_t workers : options.workers) {
                    JobSpec job = options.job;
                    job.particles = particles;
                    job.hits_per_message = granularity;
                    auto run = run_once(options, workers, job, scene_bytes, folder / "farm");
                    if (!run) return run.error();
                    run->run = round;
                    const auto [digest, first] = digests.emplace(particles, run->digest);
                    if (digest->second != run->digest)
                        return failed("two runs of " + std::to_string(particles) + " particles have other digests");
                    on_run(*run);
                    runs.push_back(std::move(*run));
                }
    return runs;
}

std::vector<FarmBenchRow> rows_of(std::span<const FarmRun> runs) {
    using Key = std::tuple<std::uint64_t, std::uint32_t, std::uint32_t>;
    const auto key_of = [](const auto& each) { return Key{each.particles, each.hits_per_message, each.workers}; };
    std::map<Key, std::vector<const FarmRun*>> alike;
    std::vector<Key> order;
    for (const FarmRun& run : runs) {
        if (!alike.contains(key_of(run))) order.push_back(key_of(run));
        alike[key_of(run)].push_back(&run);
    }
    std::vector<FarmBenchRow> rows;
    for (const Key& key : order) rows.push_back(row_of(alike.at(key)));
    for (FarmBenchRow& row : rows) {
        const FarmBenchRow* fewest = &row;
        for (const FarmBenchRow& other : rows)
            if (other.particles == row.particles && other.hits_per_message == row.hits_per_message &&
                other.workers < fewest->workers)
                fewest = &other;
        const double base = fewest->workers;
        const bool paced = row.efficiency > 0;
        row.speed_up_trace = base * fewest->trace_s / row.trace_s;
        row.speed_up_total = paced ? row.efficiency * row.workers : base * fewest->total_s / row.total_s;
        if (!paced) row.efficiency = row.speed_up_total / row.workers;
    }
    return rows;
}

}  // namespace lumenfarm
