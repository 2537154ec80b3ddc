#include "cli/bench/farm_bench.h"

#include "cli/bench/daemon.h"
#include "cli/bench/median.h"
#include "common/net/file_transfer.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <numeric>
#include <tuple>
#include <utility>

namespace lumenfarm {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// A master and its workers, connected and idle.
class Farm {
public:
    static Result<std::unique_ptr<Farm>> start(const FarmBenchOptions& options, std::uint32_t workers,
                                               const std::filesystem::path& folder);
    Result<FarmRun> run(JobSpec job, std::span<const std::byte> scene_bytes);

private:
    explicit Farm(net::BlockingClient client) : client_(std::move(client)) {}
    Result<void> start_relays(std::uint32_t relays, const std::string& master, const std::filesystem::path& folder);
    Result<void> wait_for_threads(std::uint64_t wanted);
    Result<wire::JobStatus> wait_for_end(std::uint64_t job, Clock::time_point begin);
    Result<void> check_daemons() const;
    static double cpu_s(const std::vector<std::unique_ptr<Daemon>>& daemons);

    net::BlockingClient client_;
    std::unique_ptr<Daemon> master_;
    std::vector<std::unique_ptr<Daemon>> relays_;
    std::vector<std::string> relay_addresses_;
    std::vector<std::unique_ptr<Daemon>> workers_;
};

Result<std::unique_ptr<Farm>> Farm::start(const FarmBenchOptions& options, std::uint32_t workers,
                                          const std::filesystem::path& folder) {
    auto master = Daemon::start("lumenfarm-master", {"--listen", "127.0.0.1:0", "--storage", folder / "store"},
                                folder / "master.log");
    if (!master) return master.error();
    const auto address = (*master)->wait_for("listening on ", ",");
    if (!address) return address.error();
    auto client = net::BlockingClient::connect(*net::HostPort::parse(*address), "bench");
    if (!client) return client.error();
    std::unique_ptr<Farm> farm(new Farm(std::move(*client)));
    farm->master_ = std::move(*master);
    if (const auto relayed = farm->start_relays(options.relays, *address, folder); !relayed) return relayed.error();
    for (std::uint32_t i = 1; i <= workers; ++i) {
        const std::string name = "worker-" + std::to_string(i);
        const std::string& above = options.relays > 0 ? farm->relay_addresses_[i % options.relays] : *address;
        std::vector<std::string> arguments{
            "--normal-priority", "--master",   above, "--name", name, "--threads", std::to_string(options.threads),
            "--cache",           folder / name};
        if (!options.isa.empty()) arguments.insert(arguments.end(), {"--isa", options.isa});
        if (options.memory_limit_bytes > 0)
            arguments.insert(arguments.end(), {"--memory-limit", std::to_string(options.memory_limit_bytes)});
        if (options.parts_only) arguments.emplace_back("--parts-only");
        auto worker = Daemon::start("lumenfarm-worker", std::move(arguments), folder / (name + ".log"));
        if (!worker) return worker.error();
        farm->workers_.push_back(std::move(*worker));
    }
    const auto connected = farm->wait_for_threads(std::uint64_t{workers} * options.threads);
    if (!connected) return connected.error();
    return farm;
}

Result<void> Farm::start_relays(std::uint32_t relays, const std::string& master, const std::filesystem::path& folder) {
    for (std::uint32_t i = 1; i <= relays; ++i) {
        const std::string name = "relay-" + std::to_string(i);
        auto relay =
            Daemon::start("lumenfarm-master",
                          {"--upstream", master, "--listen", "127.0.0.1:0", "--storage", folder / name, "--name", name},
                          folder / (name + ".log"));
        if (!relay) return relay.error();
        const auto address = (*relay)->wait_for("listening on ", ",");
        if (!address) return address.error();
        relays_.push_back(std::move(*relay));
        relay_addresses_.push_back(*address);
    }
    return {};
}

Result<void> Farm::check_daemons() const {
    if (auto running = master_->check_running(); !running) return running;
    for (const auto* daemons : {&relays_, &workers_})
        for (const auto& daemon : *daemons)
            if (auto running = daemon->check_running(); !running) return running;
    return {};
}

/// Relays tell how many threads are behind them.
Result<void> Farm::wait_for_threads(std::uint64_t wanted) {
    const auto begin = Clock::now();
    for (;;) {
        const auto reply = client_.ask_for<wire::WorkersReply>(wire::WorkersRequest());
        if (!reply) return reply.error();
        std::uint64_t threads = 0;
        for (const wire::WorkerStatus& worker : reply->workers) threads += worker.threads;
        if (threads == wanted) return {};
        if (auto running = check_daemons(); !running) return running;
        if (seconds_since(begin) > limits::connect_seconds * static_cast<double>(workers_.size() + 1))
            return failed("the workers do not come");
        if (const auto waited = client_.idle(0.01); !waited) return waited;
    }
}

/// Looks often enough to know the time within a hundredth, and not more often, since each look costs the master some.
Result<wire::JobStatus> Farm::wait_for_end(std::uint64_t job, Clock::time_point begin) {
    for (;;) {
        const auto reply = client_.ask_for<wire::StatusReply>(wire::StatusRequest(job));
        if (!reply) return reply.error();
        if (wire::is_over(reply->jobs.front().state)) return reply->jobs.front();
        if (auto running = check_daemons(); !running) return running.error();
        const double pause_s = std::clamp(seconds_since(begin) / 100, 0.001, 0.05);
        if (const auto waited = client_.idle(pause_s); !waited) return waited.error();
    }
}

double Farm::cpu_s(const std::vector<std::unique_ptr<Daemon>>& daemons) {
    return std::accumulate(daemons.begin(), daemons.end(), 0.0,
                           [](double sum, const auto& daemon) { return sum + daemon->cpu_seconds(); });
}

Result<FarmRun> Farm::run(JobSpec job, std::span<const std::byte> scene_bytes) {
    const double master_cpu_s = master_->cpu_seconds(), relay_cpu_s = cpu_s(relays_), worker_cpu_s = cpu_s(workers_);
    const auto begin = Clock::now();
    const auto id = net::submit_job(client_, 1, job, scene_bytes);
    if (!id) return id.error();
    const auto ended = wait_for_end(*id, begin);
    if (!ended) return ended.error();
    FarmRun run;
    run.total_s = seconds_since(begin);
    if (ended->state != wire::JobState::done) return failed("the job ended otherwise: " + ended->sentence);
    const auto farm = client_.ask_for<wire::StatusReply>(wire::StatusRequest());
    if (!farm) return farm.error();
    run.master_cpu_s = master_->cpu_seconds() - master_cpu_s;
    run.relays = static_cast<std::uint32_t>(relays_.size());
    run.relay_cpu_s = cpu_s(relays_) - relay_cpu_s;
    run.worker_cpu_s = cpu_s(workers_) - worker_cpu_s;
    run.trace_s = ended->trace_seconds;
    run.hits = ended->hits;
    run.packing = ended->packing;
    run.traffic = farm->traffic;
    run.digest = *ended->digest;
    return run;
}

Result<FarmRun> run_once(const FarmBenchOptions& options, std::uint32_t workers, const JobSpec& job,
                         std::span<const std::byte> scene_bytes, const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return failed("'" + folder.string() + "' can't be made: " + error.message());
    Result<FarmRun> run = [&]() -> Result<FarmRun> {
        const auto farm = Farm::start(options, workers, folder);
        return farm ? (*farm)->run(job, scene_bytes) : farm.error();
    }();
    std::filesystem::remove_all(folder, error);
    if (!run) return run;
    run->workers = workers;
    run->particles = job.particles;
    run->hits_per_message = job.hits_per_message;
    run->trace_s /= workers * options.threads;
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
    const auto particles = static_cast<double>(row.particles);
    row.particles_per_s = particles / row.total_s;
    row.bytes_per_particle = median_of([&](const FarmRun& run) {
        return static_cast<double>(run.traffic.bytes_in + run.traffic.bytes_out) / particles;
    });
    row.master_cpu_per_worker_cpu =
        median_of([](const FarmRun& run) { return run.worker_cpu_s > 0 ? run.master_cpu_s / run.worker_cpu_s : 0; });
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
        row.speed_up_total = base * fewest->total_s / row.total_s;
        row.speed_up_trace = base * fewest->trace_s / row.trace_s;
        row.efficiency = row.speed_up_total / row.workers;
    }
    return rows;
}

}  // namespace lumenfarm
