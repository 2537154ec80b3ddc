#pragma once

#include "cli/bench/daemon.h"
#include "cli/bench/farm_bench.h"
#include "common/net/blocking_client.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace lumenfarm {

/// A master, its relays and its workers as processes of this machine, connected and idle.
class FarmProcesses {
public:
    /// Folders and logs go to `folder`. Errors: failed (one of them does not start).
    static Result<std::unique_ptr<FarmProcesses>> start(const FarmBenchOptions& options, std::uint32_t workers,
                                                        const JobSpec& job, const std::filesystem::path& folder);
    /// The job, options.jobs times. REQUIRES: called once. Errors: failed.
    Result<FarmRun> run(std::span<const std::byte> scene_bytes);

private:
    using Clock = std::chrono::steady_clock;

    FarmProcesses(const FarmBenchOptions& options, std::uint32_t workers, JobSpec job, net::BlockingClient client)
        : options_(options), count_(workers), job_(std::move(job)), client_(std::move(client)) {}
    Result<void> start_relays(const std::string& master, const std::filesystem::path& folder);
    Result<void> start_workers(const std::filesystem::path& folder);
    Result<void> start_paced(const std::filesystem::path& folder);
    Result<void> start_paced(const std::string& name, std::uint32_t workers, double pace, const std::string& master,
                             const std::filesystem::path& folder);
    const std::string& master_of(std::uint32_t worker) const { return masters_[worker % masters_.size()]; }
    double stop_s() const;
    double ideal_s() const;
    Result<void> wait_for_threads();
    Result<std::vector<wire::JobStatus>> wait_for_end(const std::vector<std::uint64_t>& jobs, Clock::time_point begin);
    Result<void> check_daemons() const;
    static double cpu_s(const std::vector<std::unique_ptr<Daemon>>& daemons);

    const FarmBenchOptions& options_;
    std::uint32_t count_;
    JobSpec job_;
    net::BlockingClient client_;
    std::unique_ptr<Daemon> master_;
    std::vector<std::unique_ptr<Daemon>> relays_;
    std::vector<std::string> masters_;  ///< that workers go to: the relays, or the master
    std::vector<std::unique_ptr<Daemon>> workers_;
    std::unique_ptr<Daemon> stopping_;  ///< the paced workers that stop in the middle
};

}  // namespace lumenfarm
