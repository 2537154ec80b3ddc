#include "master/set_sizer.h"

#include <gtest/gtest.h>

#include <limits>

namespace lumenfarm {
namespace {

constexpr std::uint64_t plenty = 1'000'000'000;

Pace pace_of(double particles_per_s) {
    Pace pace;
    pace.learn(static_cast<std::uint64_t>(particles_per_s), 1);
    return pace;
}

TEST(SetSizer, FixedSizeIsKept) {
    EXPECT_EQ(next_set_size({50'000, 2}, pace_of(10), 100, 8), 50'000u);
    EXPECT_EQ(next_set_size({limits::particles_per_set_max * 2, 2}, {}, 100, 8), limits::particles_per_set_max);
}

TEST(SetSizer, FirstSetsAreSmall) { EXPECT_EQ(next_set_size({}, {}, plenty, 4), limits::first_set_particles); }

TEST(SetSizer, SetsAimAtTheTargetTime) {
    EXPECT_EQ(next_set_size({0, 2}, pace_of(300'000), plenty, 4), 600'000u);
    EXPECT_EQ(next_set_size({0, 0.5}, pace_of(300'000), plenty, 4), 150'000u);
}

TEST(SetSizer, SetsShrinkGuidedTowardsTheEnd) {
    EXPECT_EQ(next_set_size({0, 2}, pace_of(300'000), 800'000, 4), 100'000u);
    EXPECT_EQ(next_set_size({0, 2}, pace_of(300'000), 1'000, 4), limits::last_set_particles);
}

TEST(SetSizer, AbsurdSpeedsStayWithinTheLimits) {
    EXPECT_EQ(next_set_size({0, 1e9}, pace_of(1e15), ~0ull, 1), limits::particles_per_set_max);
    Pace pace;
    pace.learn(1, 1e300);
    EXPECT_EQ(next_set_size({0, 2}, pace, plenty, 1), limits::last_set_particles);
}

TEST(Pace, NothingIsLearntOfEmptyOrTimelessResults) {
    Pace pace;
    pace.learn(0, 1);
    pace.learn(10, 0);
    pace.learn(10, -1);
    pace.learn(10, std::numeric_limits<double>::quiet_NaN());
    EXPECT_FALSE(pace.known());
}

TEST(Pace, FollowsTheLatestMeasurements) {
    Pace pace = pace_of(1'000);
    for (int i = 0; i < 10; ++i) pace.learn(9'000, 1);
    EXPECT_NEAR(pace.particles_per_s(), 9'000, 50);
}

}  // namespace
}  // namespace lumenfarm
