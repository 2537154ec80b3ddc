#include "tests/simulation/farm.h"

#include <gtest/gtest.h>

#include <map>

namespace lumenfarm::testing {
namespace {

JobSpec small_job(std::uint64_t seed) {
    JobSpec spec;
    spec.particles = 20'000 + seed * 37;
    spec.seed = seed;
    spec.texel_m = 0.1;
    spec.keep_hits = seed % 3 == 0 ? 0 : 500;
    spec.absorption = seed % 5 == 0 ? Absorption::attenuate : Absorption::analog;
    spec.packing = seed % 2 == 0 ? Packing::maps : Packing::records;
    spec.particles_per_set = seed % 4 == 0 ? 0 : 300 + seed * 91 % 5'000;
    spec.hits_per_message = static_cast<std::uint32_t>(100 + seed * 17 % 3'000);
    return spec;
}

/// Runs to the end: every promise kept, the same bits as one tracer alone.
void expect_done(Farm& farm) {
    const bool ended = farm.run();
    for (const std::string& violation : farm.violations()) ADD_FAILURE() << violation;
    ASSERT_TRUE(ended);
    EXPECT_EQ(farm.state(), wire::JobState::done);
    EXPECT_EQ(farm.master().staged_bytes(), 0u);
}

TEST(Farm, CalmFarmsGiveTheResultOfOneTracer) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(seed);
        const JobSpec spec = small_job(seed);
        FarmOptions options;
        options.seed = seed;
        options.workers = 1 + seed % 4;
        options.threads = 1 + static_cast<std::uint32_t>(seed % 3);
        Farm farm(spec, options);
        expect_done(farm);
        EXPECT_EQ(farm.master().discarded(Discard::result_invalid), 0u);
        EXPECT_EQ(farm.master().discarded(Discard::protocol_error), 0u);
    }
}

TEST(Farm, RelaysGiveTheResultOfOneTracer) {
    for (std::uint64_t seed = 0; seed < 64; ++seed) {
        SCOPED_TRACE(seed);
        JobSpec spec = small_job(seed);
        // each way with each other
        spec.packing = seed & 1 ? Packing::maps : Packing::records;
        if (seed & 2) {
            spec.strategy = Strategy::subspaces;
            spec.subspaces = 1 + static_cast<std::uint32_t>(seed % 12);
        }
        FarmOptions options;
        options.seed = seed;
        options.relays = seed & 4 ? 2 : 1;
        options.relay_of_relay = seed & 8;
        options.workers = 1 + seed / 16 % 4;
        options.threads = 1 + static_cast<std::uint32_t>(seed % 3);
        Farm farm(spec, options);
        expect_done(farm);
        EXPECT_EQ(farm.master().discarded(Discard::result_invalid), 0u);
        EXPECT_EQ(farm.master().discarded(Discard::result_stale), 0u);
        EXPECT_EQ(farm.master().discarded(Discard::protocol_error), 0u);
        EXPECT_EQ(farm.master().discarded(Discard::lease_expired), 0u);
    }
}

TEST(Farm, SubspacesAreCutAnewWhereTheirHitsAreUneven) {
    std::uint64_t recuts = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        JobSpec spec = small_job(seed);
        spec.strategy = Strategy::subspaces;
        spec.subspaces = 4 + static_cast<std::uint32_t>(seed % 8);
        spec.particles_per_set = 500;
        FarmOptions options;
        options.seed = seed;
        options.workers = options.parts_only = 3;
        // for three of them, a plan and light maps
        options.memory_bytes = limits::worker_bytes + limits::result_bytes_in_flight + (std::uint64_t{256} << 10) +
                               options.threads * (2 * limits::result_close_bytes + (std::uint64_t{64} << 10)) +
                               3 * (limits::part_bytes + 4 * limits::part_bytes_per_triangle);
        options.master.recut_seconds = 0.5;
        options.seconds_between_power_cuts = seed % 2 == 0 ? 0 : 3;
        Farm farm(spec, options);
        expect_done(farm);
        recuts += farm.recuts();
    }
    EXPECT_GT(recuts, 5u);
}

TEST(Farm, DroppedConnectionsAndCrashedWorkersChangeNoBit) {
    std::uint64_t refused = 0;
    for (std::uint64_t seed = 1; seed <= 80; ++seed) {
        SCOPED_TRACE(seed);
        const JobSpec spec = small_job(seed);
        FarmOptions options;
        options.seed = seed;
        options.workers = 2 + seed % 4;
        options.seconds_between_drops = 0.3 + 0.05 * static_cast<double>(seed % 20);
        options.seconds_between_crashes = seed % 3 == 0 ? 0 : 2;
        Farm farm(spec, options);
        expect_done(farm);
        EXPECT_EQ(farm.master().discarded(Discard::result_invalid), 0u);
        refused += farm.master().discarded(Discard::result_stale) + farm.master().discarded(Discard::result_repeated);
    }
    EXPECT_GT(refused, 0u) << "the storms were too mild to try the ledger";
}

TEST(Farm, PowerCutsOfTheMasterLoseNothingThatWasAcknowledged) {
    std::uint64_t cuts = 0;
    std::map<Packing, std::uint64_t> snapshots;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(seed);
        const JobSpec spec = small_job(seed);
        FarmOptions options;
        options.seed = seed;
        options.workers = 1 + seed % 4;
        options.seconds_between_power_cuts = 2 + static_cast<double>(seed % 8);
        options.seconds_between_drops = seed % 3 == 0 ? 3 : 0;
        options.seconds_between_crashes = seed % 5 == 0 ? 5 : 0;
        options.master.checkpoint_seconds = seed % 4 < 2 ? 0.5 : 10;
        Farm farm(spec, options);
        expect_done(farm);
        cuts += farm.power_cuts();
        snapshots[spec.packing] += farm.snapshots();
    }
    EXPECT_GT(cuts, 40u);
    EXPECT_GT(snapshots[Packing::records], 20u);
    EXPECT_GT(snapshots[Packing::maps], 20u);
}

TEST(Farm, DisksThatFailEndTheMasterAndLoseNothing) {
    std::uint64_t lives = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(seed);
        const JobSpec spec = small_job(seed);
        FarmOptions options;
        options.seed = seed;
        options.master.disk_failures = 0.02;
        options.master.checkpoint_seconds = 0.5;
        options.seconds_between_power_cuts = seed % 2 == 0 ? 10 : 0;
        Farm farm(spec, options);
        expect_done(farm);
        lives += farm.power_cuts();
    }
    EXPECT_GT(lives, 60u);
}

TEST(Farm, FullDisksPauseTheJobAndItGoesOn) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(seed);
        const JobSpec spec = small_job(seed);
        FarmOptions options;
        options.seed = seed;
        options.seconds_between_full_disks = 3;
        options.seconds_between_power_cuts = seed % 3 == 0 ? 10 : 0;
        options.master.checkpoint_seconds = 1;
        Farm farm(spec, options);
        expect_done(farm);
    }
}

TEST(Farm, StragglersSetsAreTracedByIdleWorkers) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(seed);
        const JobSpec spec = small_job(seed);
        FarmOptions options;
        options.seed = seed;
        options.one_worker_sleeps = true;
        Farm farm(spec, options);
        expect_done(farm);
        EXPECT_LT(farm.now_s(), 1'000);
    }
}

TEST(Farm, CancelledJobKeepsWhatWasDone) {
    for (std::uint64_t seed = 1; seed <= 15; ++seed) {
        SCOPED_TRACE(seed);
        JobSpec spec = small_job(seed);
        spec.particles = 2'000'000;
        FarmOptions options;
        options.seed = seed;
        Farm farm(spec, options);
        farm.at(6, [&] { farm.cancel(); });
        ASSERT_TRUE(farm.run());
        EXPECT_EQ(farm.state(), wire::JobState::cancelled);
        EXPECT_LT(farm.now_s(), 6 + limits::finish_seconds);
        const Solution partial = farm.solution();
        EXPECT_GT(partial.balance.particles, 0u);
        EXPECT_LT(partial.balance.particles, spec.particles);
        std::uint64_t committed = 0;
        for (const IntervalSet& light : partial.committed) committed += light.size();
        EXPECT_EQ(committed, partial.balance.particles);
        EXPECT_TRUE(partial.balance.closed());
    }
}

TEST(Farm, DrainedWorkersHandBackTheirSetsAndEnd) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        JobSpec spec = small_job(seed);
        spec.particles = 200'000;
        FarmOptions options;
        options.seed = seed;
        Farm farm(spec, options);
        farm.at(1.5, [&] { farm.drain_worker(0); });
        farm.at(1.6, [&] { farm.drain_worker(1); });
        expect_done(farm);
        EXPECT_EQ(farm.workers_finished(), 2u);
        EXPECT_EQ(farm.master().discarded(Discard::lease_expired), 0u) << "leases were left behind";
    }
}

}  // namespace
}  // namespace lumenfarm::testing
