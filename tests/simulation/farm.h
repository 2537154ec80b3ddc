#pragma once

#include "common/solution/solution.h"
#include "tests/simulation/farm_checks.h"
#include "tests/simulation/simulated_client.h"
#include "tests/simulation/simulated_master.h"
#include "tests/simulation/simulated_relay.h"
#include "tests/simulation/simulated_worker.h"
#include "tests/simulation/world.h"

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

/// A whole farm in one thread under a fake clock: the real cores and the real storage, a fake tracer, a network, a disk
/// and machines that are against it. One seed replays it. What must hold is checked after every event (farm_checks.h);
/// the farm stops where it does not.
namespace lumenfarm::testing {

struct FarmOptions {
    std::uint64_t seed = 1;
    std::size_t workers = 3;
    std::uint32_t threads = 2;
    std::size_t relays = 0;       ///< between the master and all workers but some
    bool relay_of_relay = false;  ///< the second relay's master is the first one
    std::size_t relay_bytes_in_flight = limits::relay_bytes_in_flight;
    std::uint64_t memory_bytes = 0;                ///< of each worker; 0: no limit
    std::size_t parts_only = 0;                    ///< so many of the workers never take a scene whole
    double slice_s_min = 0.01, slice_s_max = 0.2;  ///< of a worker's tracing
    std::uint64_t first_lies_one_in = 0;           ///< of so many slices of the first worker one is wrong; 0: none
    bool one_worker_sleeps = false;                ///< is alive, and traces nothing for a very long time
    double latency_s = 0.05;                       ///< at most, usually
    double latency_spike_s = 0;                    ///< more for one message in a hundred, on the average

    double storm_seconds = std::numeric_limits<double>::infinity();  ///< then nothing bad happens any more
    double seconds_between_drops = 0;                                ///< of connections; 0 here and below: never
    double seconds_between_partitions = 0;                           ///< of some hosts, in one or both directions
    double partition_seconds_max = 60;
    double seconds_between_crashes = 0;  ///< of workers, which start again as new processes
    double machine_crashes = 0;          ///< fraction of these and the next that takes the machine along
    double seconds_between_relay_crashes = 0;
    double seconds_between_power_cuts = 0;  ///< of the master; it starts again with what the disk has left
    double seconds_between_full_disks = 0;  ///< for some seconds each
    MasterConditions master;
};

/// While a worker lives, is reached and traces, and the master's disk works, some particle is committed or some job
/// ends within this time: the last trouble is noticed, everybody has come back, leases of those that have not are free
/// again, and a slice of these farms is traced, closed and stored.
constexpr double progress_seconds_max = limits::dead_seconds + limits::reconnect_seconds_max + limits::connect_seconds +
                                        limits::hello_seconds +
                                        std::max(limits::restart_seconds, limits::reconnect_seconds) +
                                        limits::disk_retry_seconds + limits::finish_seconds + 30;
/// While a client's network and the master's disk work, a question of it is answered within this time.
constexpr double answer_seconds_max =
    limits::dead_seconds + limits::reply_seconds + limits::connect_seconds + limits::hello_seconds + 15;

class Farm {
public:
    Farm(const std::vector<ClientPlan>& clients, const FarmOptions& options);
    Farm(const JobSpec& spec, const FarmOptions& options) : Farm({ClientPlan(spec)}, options) {}

    /// Runs until every client was told that its job is over. False when something was violated.
    bool run();
    void at(double time_s, std::function<void()> event) { world_.clock.at(time_s, std::move(event)); }

    // Of the first client's job
    void cancel() { master_->cancel(clients_.front()->job()); }
    wire::JobState state() const;
    /// As it lies on the master's disk. REQUIRES: run() was true.
    Solution solution() { return solution_of(*clients_.front()); }

    void drain_worker(std::size_t index) { workers_[index].drain(); }
    void drain_relay(std::size_t index) { relays_[index].drain(); }
    bool relay_is_alive(std::size_t index) const { return relays_[index].alive(); }
    const MasterCore& master() const { return *master_->core(); }
    const std::vector<std::string>& violations() const { return checks_.violations(); }
    std::uint64_t recuts() const { return checks_.recuts(); }
    const History& history() const { return world_.history; }
    std::uint64_t power_cuts() const { return master_->lives() - 1; }
    std::uint64_t snapshots() const { return master_->snapshots(); }
    double now_s() const { return world_.now_s(); }
    std::size_t workers_finished() const;

private:
    // what is against the farm (farm_storms.cpp)
    void begin_storms();
    void repeat(double mean_s, std::function<void()> event);
    void drop_one();
    void crash_one();
    void crash_relay();
    void cut_power();
    void fill_disk();
    void partition();
    void block(HostId host, bool to_master, bool to_peer, double seconds);
    /// The host is in trouble until then.
    void trouble(HostId host, double until_s) { calm_since_s_[host] = std::max(calm_since_s_[host], until_s); }

    void start_worker(std::size_t index);
    void start_relay(std::size_t index);
    /// The relay that is the worker's master; none: the farm's master is.
    std::optional<std::size_t> relay_of(std::size_t worker) const;
    SimulatedNetwork& network_of(std::size_t worker);
    double calm_since_s(std::size_t worker);
    bool over() const;
    void check_step();
    void check_progress();
    void check_answers();
    bool master_is_calm() const { return master_->core() && master_->disk_works(); }
    void check_results();
    Solution solution_of(const SimulatedClient& client);

    FarmOptions options_;
    World world_;
    FarmChecks checks_;
    std::deque<SimulatedRelay> relays_;
    std::deque<SimulatedWorker> workers_;
    std::vector<std::unique_ptr<SimulatedClient>> clients_;
    std::unique_ptr<SimulatedMaster> master_;
    std::uint64_t next_instance_ = 1;
    std::map<HostId, double> calm_since_s_;
    double master_calm_since_s_ = 0;
    std::uint64_t progress_ = 0;  ///< changes when something was achieved
    double progress_s_ = 0;       ///< when it changed last
};

}  // namespace lumenfarm::testing
