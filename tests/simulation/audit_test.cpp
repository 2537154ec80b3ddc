#include "tests/simulation/farm.h"

#include <gtest/gtest.h>

/// Workers whose memory flips bits, in farms that trace a part of the results again.
namespace lumenfarm::testing {
namespace {

constexpr std::uint64_t one_in_twenty = 20;

struct AuditedFarm {
    JobSpec spec;
    FarmOptions options;
    AuditedFarm(std::uint64_t seed, Packing packing, std::uint64_t keep_hits) {
        spec.particles = 800'000;
        spec.particles_per_set = 200;
        spec.seed = seed;
        spec.texel_m = 0.25;
        spec.keep_hits = keep_hits;
        spec.packing = packing;
        options.seed = seed;
        options.workers = 4;
        options.threads = 2;
        options.first_lies_one_in = one_in_twenty;
        options.master.audit_fraction = 0.02;
        options.master.checkpoint_seconds = 5;
    }
};

struct Packed {
    Packing packing;
    std::uint64_t keep_hits;
};

class LyingWorkers : public ::testing::TestWithParam<Packed> {};

/// The liar has 1,000 sets of the job, of which 50 are wrong; a seed may let it through.
TEST_P(LyingWorkers, AreFoundAndWhatTheyTracedIsTracedAgain) {
    int found = 0, retracted_later = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        const AuditedFarm audited(seed, GetParam().packing, GetParam().keep_hits);
        Farm farm(audited.spec, audited.options);
        const bool right = farm.run();
        const auto status = farm.master().status(1, farm.now_s());
        ASSERT_TRUE(status);
        if (status->liars == 0) continue;  // the digest is wrong then, as it must be
        ++found;
        retracted_later += farm.now_s() > 20;
        EXPECT_TRUE(right);
        for (const std::string& violation : farm.violations()) ADD_FAILURE() << violation;
        EXPECT_EQ(farm.state(), wire::JobState::done);
        EXPECT_EQ(farm.workers_finished(), 1u) << "the liar is kept out";
    }
    EXPECT_GE(found, 4);
    EXPECT_GT(retracted_later, 0) << "not only before there was a snapshot";
}

/// The job is paused, resumed and extended meanwhile, and machines crash, the liar's and the master's too.
TEST_P(LyingWorkers, AreFoundThroughPausesAndCrashes) {
    int found = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        AuditedFarm audited(seed, GetParam().packing, GetParam().keep_hits);
        audited.options.master.audit_fraction = 0.1;
        audited.options.seconds_between_crashes = 10;
        audited.options.seconds_between_power_cuts = seed % 2 == 0 ? 20 : 0;
        audited.options.storm_seconds = 40;
        ClientPlan plan(audited.spec);
        plan.pause_after_s = 5;
        plan.extend_after_s = 12;
        plan.extended_particles = audited.spec.particles + 50'000;
        Farm farm({plan}, audited.options);
        const bool right = farm.run();
        const auto status = farm.master().status(1, farm.now_s());
        ASSERT_TRUE(status);
        if (status->liars == 0) continue;
        ++found;
        EXPECT_TRUE(right);
        for (const std::string& violation : farm.violations()) ADD_FAILURE() << violation;
    }
    EXPECT_GE(found, 4);
}

INSTANTIATE_TEST_SUITE_P(Packings, LyingWorkers,
                         ::testing::Values(Packed{Packing::records, 0}, Packed{Packing::records, 500},
                                           Packed{Packing::maps, 0}, Packed{Packing::maps, 500}));

TEST(HonestWorkers, AreNeverCalledLiars) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        AuditedFarm audited(seed, seed % 2 == 0 ? Packing::maps : Packing::records, seed % 3 == 0 ? 500 : 0);
        audited.spec.particles = 20'000;
        audited.options.first_lies_one_in = 0;
        audited.options.master.audit_fraction = 0.3;
        audited.options.seconds_between_drops = 2;
        audited.options.seconds_between_crashes = seed % 2 == 0 ? 10 : 0;
        Farm farm(audited.spec, audited.options);
        EXPECT_TRUE(farm.run());
        for (const std::string& violation : farm.violations()) ADD_FAILURE() << violation;
        EXPECT_EQ(farm.master().status(1, farm.now_s())->liars, 0u);
    }
}

}  // namespace
}  // namespace lumenfarm::testing
