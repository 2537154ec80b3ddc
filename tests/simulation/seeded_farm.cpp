#include "tests/simulation/seeded_farm.h"

#include <cmath>

namespace lumenfarm::testing {

namespace {

constexpr std::uint64_t map_bytes_max = 64u << 10;    ///< of a job on the small scene, generously
constexpr std::uint64_t plan_bytes_max = 256u << 10;  ///< in memory

/// Small values are as frequent as large ones.
double magnitude(Chance& chance, double low, double high) {
    return std::exp(chance.uniform(std::log(low), std::log(high)));
}

/// How often something happens that happens in a part of the farms only.
double perhaps(Chance& chance, double probability, double mean_s_low, double mean_s_high) {
    const double mean_s = magnitude(chance, mean_s_low, mean_s_high);
    return chance.happens(probability) ? mean_s : 0;
}

ClientPlan random_client(Chance& chance) {
    ClientPlan plan;
    JobSpec& spec = plan.spec;
    spec.particles = static_cast<std::uint64_t>(magnitude(chance, 2'000, 20'000));
    spec.seed = chance.number(1, 1'000'000);
    spec.texel_m = 0.25;
    spec.keep_hits = chance.happens(0.3) ? 300 : 0;
    spec.absorption = chance.happens(0.2) ? Absorption::attenuate : Absorption::analog;
    spec.packing = chance.happens(0.5) ? Packing::maps : Packing::records;
    spec.particles_per_set = chance.happens(0.2) ? 0 : chance.number(100, 2'500);
    spec.hits_per_message = static_cast<std::uint32_t>(chance.number(100, 3'000));
    if (chance.happens(0.3)) {
        spec.strategy = Strategy::subspaces;
        spec.subspaces = static_cast<std::uint32_t>(chance.number(1, 12));
    }
    spec.priority = static_cast<std::int32_t>(chance.number(0, 2));
    plan.submit_s = chance.uniform(0, 10);
    if (chance.happens(0.15)) plan.cancel_after_s = chance.exponential(15);
    if (chance.happens(0.2)) plan.pause_after_s = chance.exponential(10);
    if (chance.happens(0.2)) plan.extend_after_s = chance.exponential(20);
    plan.extended_particles = spec.particles + chance.number(1, 10'000);
    return plan;
}

FarmOptions random_options(Chance& chance, std::uint64_t seed) {
    FarmOptions options;
    options.seed = seed;
    options.workers = chance.number(1, 5);
    options.threads = static_cast<std::uint32_t>(chance.number(1, 3));
    if (chance.happens(0.5))
        options.memory_bytes = limits::worker_bytes + limits::result_bytes_in_flight + plan_bytes_max +
                               options.threads * (2 * limits::result_close_bytes + map_bytes_max) +
                               chance.number(1, 8) * (limits::part_bytes + 4 * limits::part_bytes_per_triangle);
    options.parts_only = chance.number(0, 5);
    options.slice_s_min = magnitude(chance, 0.05, 4);
    options.slice_s_max = 3 * options.slice_s_min;
    options.one_worker_sleeps = options.workers > 1 && chance.happens(0.1);
    options.latency_s = magnitude(chance, 0.01, 0.5);
    options.latency_spike_s = perhaps(chance, 0.5, 0.3, 3);
    options.storm_seconds = magnitude(chance, 15, 120);
    options.seconds_between_drops = perhaps(chance, 0.5, 1, 20);
    options.seconds_between_partitions = perhaps(chance, 0.5, 5, 30);
    options.partition_seconds_max = magnitude(chance, 5, 120);
    options.seconds_between_crashes = perhaps(chance, 0.4, 2, 30);
    options.machine_crashes = chance.uniform(0, 0.6);
    options.seconds_between_power_cuts = perhaps(chance, 0.4, 3, 40);
    options.seconds_between_full_disks = perhaps(chance, 0.25, 5, 20);
    options.master.down_s = magnitude(chance, 0.1, 20);
    options.master.disk_failures = chance.happens(0.15) ? magnitude(chance, 0.001, 0.02) : 0;
    options.master.checkpoint_seconds = magnitude(chance, 0.5, 10);
    options.master.audit_fraction = perhaps(chance, 0.3, 0.05, 1);
    options.master.bad_chunks = chance.happens(0.1) ? 0.3 : 0;
    options.master.recut_seconds = magnitude(chance, 0.5, 20);
    options.relays = chance.happens(0.4) ? chance.number(1, 2) : 0;
    options.relay_of_relay = chance.happens(0.5);
    if (chance.happens(0.3)) options.relay_bytes_in_flight = static_cast<std::size_t>(magnitude(chance, 100, 100'000));
    options.seconds_between_relay_crashes = perhaps(chance, 0.5, 3, 40);
    return options;
}

}  // namespace

std::unique_ptr<Farm> make_seeded_farm(std::uint64_t seed) {
    Chance chance(seed + 0x5eed);  // another row of numbers than the farm's own
    std::vector<ClientPlan> clients{random_client(chance)};
    while (clients.size() < 3 && chance.happens(0.3)) clients.push_back(random_client(chance));
    return std::make_unique<Farm>(clients, random_options(chance, seed));
}

}  // namespace lumenfarm::testing
