// How a real master bears many connections: idle sessions, busy workers, and, if asked for, workers that join and leave
// every second. Prints a line every ten seconds: the master's memory and descriptors, and how long heartbeats wait for
// their answers. docs/operations.md has figures.
#include "cli/import/import.h"
#include "common/net/file_transfer.h"
#include "common/scene/scene_file.h"
#include "common/transport/fingerprint.h"
#include "tests/bench/farm_load.h"
#include "tests/loopback/process.h"

#include <sys/resource.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace lumenfarm;
using testing::Process;
namespace fs = std::filesystem;

struct Load {
    std::size_t idle = 1'000;
    std::size_t busy = 100;
    double minutes = 2;
    bool churn = false;
    std::string scene = LUMENFARM_SOURCE_DIR "/scenes/cornell.gltf";
};

/// "VmRSS" and the like of a process [MiB].
double memory_mib(pid_t process, const std::string& field) {
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with(field + ":")) return std::stod(line.substr(field.size() + 1)) / 1'024;
    return 0;
}

std::size_t descriptors(pid_t process) {
    const fs::directory_iterator all("/proc/" + std::to_string(process) + "/fd");
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

double quantile(const std::vector<double>& sorted, double fraction) {
    return sorted.empty() ? 0 : sorted[static_cast<std::size_t>(fraction * static_cast<double>(sorted.size() - 1))];
}

/// Workers of one thread that trace; in churn the oldest leaves and a new one joins.
class BusyWorkers {
public:
    BusyWorkers(std::string master, fs::path folder) : master_(std::move(master)), folder_(std::move(folder)) {}

    void join() {
        workers_.push_back(std::make_unique<Process>(
            std::vector<std::string>{testing::program("lumenfarm-worker"), "--master", master_, "--threads", "1",
                                     "--cache", folder_, "--name", "busy-" + std::to_string(++hired_)}));
    }
    /// Without a word: it is killed.
    void leave() { workers_.pop_front(); }
    void read_logs() {
        for (auto& worker : workers_) worker->read_now();
    }
    std::size_t size() const { return workers_.size(); }

private:
    std::string master_;
    fs::path folder_;
    std::deque<std::unique_ptr<Process>> workers_;
    std::uint64_t hired_ = 0;
};

/// Workers that hold leases, as the master sees it.
std::size_t working(const std::string& master) {
    auto client = net::BlockingClient::connect(*net::HostPort::parse(master), "bench");
    if (!client) return 0;
    const auto reply = client->ask_for<wire::WorkersReply>(wire::WorkersRequest());
    if (!reply) return 0;
    return static_cast<std::size_t>(std::ranges::count_if(
        reply->workers, [](const wire::WorkerStatus& worker) { return worker.state == wire::WorkerState::working; }));
}

/// Long jobs, so that the workers always have one.
class Jobs {
public:
    Jobs(const std::string& master, std::vector<std::byte> scene)
        : master_(*net::HostPort::parse(master)), scene_(std::move(scene)) {}

    /// Submits one where each is more than half done.
    Result<void> keep_coming() {
        auto client = net::BlockingClient::connect(master_, "bench");
        if (!client) return client.error();
        const auto farm = client->ask_for<wire::StatusReply>(wire::StatusRequest());
        if (!farm) return farm.error();
        const auto lasts = [](const wire::JobStatus& job) { return job.committed < job.particles / 2; };
        if (std::ranges::any_of(farm->jobs, lasts)) return {};
        JobSpec spec;
        spec.particles = limits::particles_max;
        spec.seed = ++submitted_;
        const auto job = net::submit_job(*client, submitted_, spec, scene_);
        if (!job) return job.error();
        return {};
    }

private:
    net::HostPort master_;
    std::vector<std::byte> scene_;
    std::uint64_t submitted_ = 0;
};

int run(const Load& load, const fs::path& folder) {
    Process master({testing::program("lumenfarm-master"), "--listen", "127.0.0.1:0", "--storage", folder / "store"});
    const auto listening = [&] { return master.err().find(", storage") != std::string::npos; };
    if (!master.read_until(listening)) return std::cerr << master.err(), 1;
    const auto at = master.err().find("listening on ") + 13;
    const std::string address = master.err().substr(at, master.err().find(',', at) - at);
    const auto imported = import_scene(load.scene, {});
    if (!imported) return std::cerr << imported.error().sentence << "\n", 1;
    Jobs jobs(address, encode_scene(imported->scene));

    boost::asio::io_context io;
    bench::IdleSessions idle(io, *net::HostPort::parse(address), *transport_fingerprint(""), 5);
    BusyWorkers busy(address, folder / "cache");
    idle.keep(load.idle);
    std::vector<double> answers;
    std::printf("%8s %6s %6s %8s %8s %6s %9s %9s %9s %9s\n", "s", "idle", "busy", "RSS MiB", "peak MiB", "fds",
                "answers", "p50 ms", "p99 ms", "max ms");
    const auto begin = testing::Clock::now();
    const auto elapsed_s = [&] { return std::chrono::duration<double>(testing::Clock::now() - begin).count(); };
    for (int second = 1; elapsed_s() < 60 * load.minutes; ++second) {
        if (load.churn && busy.size() == load.busy) {
            busy.leave();
        } else {
            for (int i = 0; i < (load.churn ? 1 : 5) && busy.size() < load.busy; ++i) busy.join();
        }
        // a program whose log nobody reads stands still
        for (int tenth = 0; tenth < 10; ++tenth) {
            io.restart();
            io.run_for(std::chrono::milliseconds(100));
            master.read_now();
        }
        busy.read_logs();
        for (const double answer : idle.take_answers()) answers.push_back(1'000 * answer);
        if (second % 10 != 1) continue;
        if (const auto coming = jobs.keep_coming(); !coming) return std::cerr << coming.error().sentence << "\n", 1;
        if (second == 1) continue;
        std::ranges::sort(answers);
        std::printf("%8.0f %6zu %6zu %8.1f %8.1f %6zu %9zu %9.2f %9.2f %9.2f\n", elapsed_s(), idle.open(),
                    working(address), memory_mib(master.id(), "VmRSS"), memory_mib(master.id(), "VmHWM"),
                    descriptors(master.id()), answers.size(), quantile(answers, 0.5), quantile(answers, 0.99),
                    quantile(answers, 1));
        std::fflush(stdout);
        answers.clear();
    }
    std::printf("idle sessions lost: %llu\n", static_cast<unsigned long long>(idle.lost()));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Measures a real master under many connections.", "farm_bench");
    Load load;
    app.add_option("--idle", load.idle, "sessions that only exchange heartbeats")->capture_default_str();
    app.add_option("--busy", load.busy, "workers of one thread that trace")->capture_default_str();
    app.add_option("--minutes", load.minutes, "how long")->capture_default_str();
    app.add_flag("--churn", load.churn, "every second a busy worker joins or is killed");
    app.add_option("--scene", load.scene, "of the job")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
        limit.rlim_cur = limit.rlim_max;
        setrlimit(RLIMIT_NOFILE, &limit);
    }
    const testing::Folder folder;
    return run(load, folder / "");
}
