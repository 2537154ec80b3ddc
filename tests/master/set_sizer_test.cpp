#include "master/set_sizer.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace lumenfarm {
namespace {

constexpr std::uint64_t plenty = 1'000'000'000;

Pace pace_of(double particles_per_s) {
    Pace pace;
    pace.learn(static_cast<std::uint64_t>(particles_per_s), 1);
    return pace;
}

TEST(SetSizer, FixedSizeIsKept) {
    EXPECT_EQ(next_set_size({50'000, 2}, pace_of(10), {100, 8, 1}), 50'000u);
    EXPECT_EQ(next_set_size({limits::particles_per_set_max * 2, 2}, {}, {100, 8, 1}), limits::particles_per_set_max);
}

TEST(SetSizer, FirstSetsAreSmall) { EXPECT_EQ(next_set_size({}, {}, {plenty, 4, 1}), limits::first_set_particles); }

TEST(SetSizer, FirstSetsOfALightThatShouldCostMoreAreSmaller) {
    EXPECT_EQ(next_set_size({}, {}, {plenty, 4, 1, 2}), limits::first_set_particles / 2);
    EXPECT_EQ(next_set_size({}, {}, {plenty, 4, 1, 0.5}), limits::first_set_particles * 2);
    EXPECT_EQ(next_set_size({0, 2}, pace_of(300'000), {plenty, 4, 1, 2}), 600'000u) << "measured";
}

TEST(SetSizer, UntilThePaceIsKnownSetsDoubleRoundByRound) {
    Pace pace;
    std::vector<std::uint64_t> sizes;
    for (int i = 0; i < 13; ++i) {
        sizes.push_back(next_set_size({}, pace, {plenty, 4, 2}));
        pace.give();
    }
    EXPECT_EQ(sizes, (std::vector<std::uint64_t>{1'000, 1'000, 1'000, 1'000, 2'000, 2'000, 2'000, 2'000, 4'000, 4'000,
                                                 4'000, 4'000, 8'000}));
    EXPECT_EQ(next_set_size({}, pace, {8'000, 4, 2}), 1'000u) << "but guided";
    for (int i = 0; i < 1'000; ++i) pace.give();
    EXPECT_LE(next_set_size({}, pace, {plenty, 4, 2}), limits::particles_per_set_max);
    pace.learn(5'000, 1);
    EXPECT_EQ(next_set_size({}, pace, {plenty, 4, 2}), 10'000u);
}

TEST(SetSizer, TheLastSetsAreNotTooShortForAQuickThread) {
    EXPECT_EQ(next_set_size({0, 2}, pace_of(4'000'000), {1'000, 40, 1}), 40'000u) << "10 ms";
}

TEST(SetSizer, SetsAimAtTheTargetTime) {
    EXPECT_EQ(next_set_size({0, 2}, pace_of(300'000), {plenty, 4, 1}), 600'000u);
    EXPECT_EQ(next_set_size({0, 0.5}, pace_of(300'000), {plenty, 4, 1}), 150'000u);
}

TEST(SetSizer, SetsShrinkGuidedTowardsTheEnd) {
    EXPECT_EQ(next_set_size({0, 2}, pace_of(300'000), {800'000, 4, 1}), 100'000u);
    EXPECT_EQ(next_set_size({0, 2}, pace_of(3'000), {1'000, 4, 1}), limits::last_set_particles);
}

TEST(SetSizer, AbsurdSpeedsStayWithinTheLimits) {
    EXPECT_EQ(next_set_size({0, 1e9}, pace_of(1e15), {~0ull, 1, 1}), limits::particles_per_set_max);
    Pace pace;
    pace.learn(1, 1e300);
    EXPECT_EQ(next_set_size({0, 2}, pace, {plenty, 1, 1}), limits::last_set_particles);
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
