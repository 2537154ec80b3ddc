#include "cli/bench/farm_processes.h"

#include "common/net/file_transfer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <numeric>
#include <utility>

namespace lumenfarm {

namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// To be read again as the same number.
std::string exact(double value) {
    std::array<char, 64> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return {text.data(), end};
}

/// Of masters and relays alike.
std::vector<std::string> serving_arguments(const FarmBenchOptions& options, const std::string& storage) {
    std::vector<std::string> arguments{"--listen", "127.0.0.1:0", "--storage", storage};
    if (options.flush_seconds > 0) arguments.insert(arguments.end(), {"--flush-seconds", exact(options.flush_seconds)});
    if (options.set_seconds > 0) arguments.insert(arguments.end(), {"--set-seconds", exact(options.set_seconds)});
    if (options.results_in_flight > 0)
        arguments.insert(arguments.end(), {"--results-in-flight", std::to_string(options.results_in_flight)});
    if (options.compress) arguments.emplace_back("--compress");
    if (options.paced) arguments.emplace_back("--paced-workers");
    return arguments;
}

/// What decides the stored results of paced workers.
std::vector<std::string> result_arguments(const JobSpec& job) {
    return {"--seed",        std::to_string(job.seed),
            "--absorption",  job.absorption == Absorption::analog ? "analog" : "attenuate",
            "--cutoff",      exact(job.cutoff),
            "--cutoff-rule", job.cutoff_rule == CutoffRule::roulette ? "roulette" : "plain",
            "--texel",       exact(job.texel_m),
            "--packing",     std::string(name_of(job.packing))};
}

}  // namespace

Result<std::unique_ptr<FarmProcesses>> FarmProcesses::start(const FarmBenchOptions& options, std::uint32_t workers,
                                                            const JobSpec& job, const std::filesystem::path& folder) {
    auto master =
        Daemon::start("lumenfarm-master", serving_arguments(options, folder / "store"), folder / "master.log");
    if (!master) return master.error();
    const auto address = (*master)->wait_for("listening on ", ",");
    if (!address) return address.error();
    auto client = net::BlockingClient::connect(*net::HostPort::parse(*address), "bench");
    if (!client) return client.error();
    std::unique_ptr<FarmProcesses> farm(new FarmProcesses(options, workers, job, std::move(*client)));
    farm->master_ = std::move(*master);
    if (const auto started = farm->start_relays(*address, folder); !started) return started.error();
    if (farm->masters_.empty()) farm->masters_ = {*address};
    const auto started = options.paced ? farm->start_paced(folder) : farm->start_workers(folder);
    if (!started) return started.error();
    if (const auto connected = farm->wait_for_threads(); !connected) return connected.error();
    return farm;
}

Result<void> FarmProcesses::start_relays(const std::string& master, const std::filesystem::path& folder) {
    for (std::uint32_t i = 1; i <= options_.relays; ++i) {
        const std::string name = "relay-" + std::to_string(i);
        auto arguments = serving_arguments(options_, folder / name);
        arguments.insert(arguments.end(), {"--upstream", master, "--name", name});
        auto relay = Daemon::start("lumenfarm-master", std::move(arguments), folder / (name + ".log"));
        if (!relay) return relay.error();
        const auto address = (*relay)->wait_for("listening on ", ",");
        if (!address) return address.error();
        relays_.push_back(std::move(*relay));
        masters_.push_back(*address);
    }
    return {};
}

Result<void> FarmProcesses::start_workers(const std::filesystem::path& folder) {
    for (std::uint32_t i = 1; i <= count_; ++i) {
        const std::string name = "worker-" + std::to_string(i);
        std::vector<std::string> arguments{"--normal-priority", "--master", master_of(i), "--name", name};
        arguments.insert(arguments.end(), {"--threads", std::to_string(options_.threads), "--cache", folder / name});
        if (!options_.isa.empty()) arguments.insert(arguments.end(), {"--isa", options_.isa});
        if (options_.memory_limit_bytes > 0)
            arguments.insert(arguments.end(), {"--memory-limit", std::to_string(options_.memory_limit_bytes)});
        if (options_.parts_only) arguments.emplace_back("--parts-only");
        auto worker = Daemon::start("lumenfarm-worker", std::move(arguments), folder / (name + ".log"));
        if (!worker) return worker.error();
        workers_.push_back(std::move(*worker));
    }
    return {};
}

/// A process for those of each relay, and one each for those that are slow and that stop.
Result<void> FarmProcesses::start_paced(const std::filesystem::path& folder) {
    const PacedBench& paced = *options_.paced;
    const std::uint32_t others = count_ - paced.slow - paced.stopped;
    const auto parts = static_cast<std::uint32_t>(masters_.size());
    for (std::uint32_t i = 0; i < parts; ++i) {
        const std::uint32_t workers = others / parts + (i < others % parts ? 1 : 0);
        const std::string name = "paced-" + std::to_string(i + 1);
        if (auto started = start_paced(name, workers, paced.particles_per_s, masters_[i], folder); !started)
            return started;
    }
    if (auto started =
            start_paced("slow", paced.slow, paced.particles_per_s / PacedBench::slowness, masters_.front(), folder);
        !started)
        return started;
    if (auto started = start_paced("stopping", paced.stopped, paced.particles_per_s, masters_.back(), folder); !started)
        return started;
    if (paced.stopped == 0) return {};
    stopping_ = std::move(workers_.back());
    workers_.pop_back();
    return {};
}

Result<void> FarmProcesses::start_paced(const std::string& name, std::uint32_t workers, double pace,
                                        const std::string& master, const std::filesystem::path& folder) {
    if (workers == 0) return {};
    const PacedBench& paced = *options_.paced;
    std::vector<std::string> arguments{"bench",           "paced",  paced.scene_file, "--stored",
                                       paced.stored_file, "--pace", exact(pace)};
    arguments.insert(arguments.end(), {"--master", master, "--name", name, "--cache", folder / name});
    arguments.insert(arguments.end(), {"--workers", std::to_string(workers)});
    arguments.insert(arguments.end(), {"--threads", std::to_string(options_.threads)});
    const auto results = result_arguments(job_);
    arguments.insert(arguments.end(), results.begin(), results.end());
    if (!options_.isa.empty()) arguments.insert(arguments.end(), {"--isa", options_.isa});
    auto worker = Daemon::start("lumenfarm", std::move(arguments), folder / (name + ".log"));
    if (!worker) return worker.error();
    workers_.push_back(std::move(*worker));
    return {};
}

Result<void> FarmProcesses::check_daemons() const {
    if (auto running = master_->check_running(); !running) return running;
    for (const auto* daemons : {&relays_, &workers_})
        for (const auto& daemon : *daemons)
            if (auto running = daemon->check_running(); !running) return running;
    if (stopping_) return stopping_->check_running();
    return {};
}

/// Relays tell how many threads are behind them.
Result<void> FarmProcesses::wait_for_threads() {
    const std::uint64_t wanted = std::uint64_t{count_} * options_.threads;
    const auto begin = Clock::now();
    for (;;) {
        const auto reply = client_.ask_for<wire::WorkersReply>(wire::WorkersRequest());
        if (!reply) return reply.error();
        std::uint64_t threads = 0;
        for (const wire::WorkerStatus& worker : reply->workers) threads += worker.threads;
        if (threads == wanted) return {};
        if (auto running = check_daemons(); !running) return running;
        if (seconds_since(begin) > limits::connect_seconds * static_cast<double>(count_ + 1))
            return failed("the workers do not come");
        if (const auto waited = client_.idle(0.01); !waited) return waited;
    }
}

namespace {

double thread_seconds(const FarmBenchOptions& options, const JobSpec& job) {
    return static_cast<double>(job.particles) * options.jobs / options.paced->particles_per_s / options.threads;
}

}  // namespace

/// Half of the time that all would take.
double FarmProcesses::stop_s() const {
    const PacedBench& paced = *options_.paced;
    return thread_seconds(options_, job_) / (count_ - paced.slow + paced.slow / PacedBench::slowness) / 2;
}

double FarmProcesses::ideal_s() const {
    if (!options_.paced) return 0;
    const PacedBench& paced = *options_.paced;
    const double lasting = count_ - paced.slow - paced.stopped + paced.slow / PacedBench::slowness;
    return (thread_seconds(options_, job_) - paced.stopped * stop_s()) / lasting;
}

/// Looks often enough to know the time within a hundredth, and not more often, since each look costs the master some.
Result<std::vector<wire::JobStatus>> FarmProcesses::wait_for_end(const std::vector<std::uint64_t>& jobs,
                                                                 Clock::time_point begin) {
    std::vector<wire::JobStatus> ended;
    while (ended.size() < jobs.size()) {
        if (stopping_ && seconds_since(begin) >= stop_s()) stopping_->suspend();
        const auto reply = client_.ask_for<wire::StatusReply>(wire::StatusRequest(jobs[ended.size()]));
        if (!reply) return reply.error();
        if (wire::is_over(reply->jobs.front().state)) {
            ended.push_back(reply->jobs.front());
            continue;
        }
        if (auto running = check_daemons(); !running) return running.error();
        const double pause_s = std::clamp(seconds_since(begin) / 100, 0.001, 0.05);
        if (const auto waited = client_.idle(pause_s); !waited) return waited.error();
    }
    return ended;
}

double FarmProcesses::cpu_s(const std::vector<std::unique_ptr<Daemon>>& daemons) {
    return std::accumulate(daemons.begin(), daemons.end(), 0.0,
                           [](double sum, const auto& daemon) { return sum + daemon->cpu_seconds(); });
}

Result<FarmRun> FarmProcesses::run(std::span<const std::byte> scene_bytes) {
    const double master_cpu_s = master_->cpu_seconds(), relay_cpu_s = cpu_s(relays_), worker_cpu_s = cpu_s(workers_);
    const auto begin = Clock::now();
    std::vector<std::uint64_t> jobs;
    for (std::uint32_t key = 1; key <= options_.jobs; ++key) {
        const auto id = net::submit_job(client_, key, job_, scene_bytes);
        if (!id) return id.error();
        jobs.push_back(*id);
    }
    const auto ended = wait_for_end(jobs, begin);
    if (!ended) return ended.error();
    FarmRun run;
    run.total_s = seconds_since(begin);
    run.master_cpu_s = master_->cpu_seconds() - master_cpu_s;
    run.relay_cpu_s = cpu_s(relays_) - relay_cpu_s;
    run.worker_cpu_s = options_.paced ? 0 : cpu_s(workers_) - worker_cpu_s;
    run.digest = ended->front().digest.value_or(Digest());
    for (const wire::JobStatus& job : *ended) {
        if (job.state != wire::JobState::done) return failed("a job ended otherwise: " + job.sentence);
        if (job.digest != run.digest) return failed("two results of one job differ");
        run.trace_s += job.trace_seconds / count_ / options_.threads;
        if (options_.paced) run.worker_cpu_s += job.trace_seconds;
        run.hits += job.hits;
        run.packing = job.packing;
    }
    const auto farm = client_.ask_for<wire::StatusReply>(wire::StatusRequest());
    if (!farm) return farm.error();
    run.traffic = farm->traffic;
    run.workers = count_;
    run.relays = static_cast<std::uint32_t>(relays_.size());
    run.particles = job_.particles;
    run.hits_per_message = job_.hits_per_message;
    run.jobs = options_.jobs;
    run.ideal_s = ideal_s();
    return run;
}

}  // namespace lumenfarm
