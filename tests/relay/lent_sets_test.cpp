#include "relay/lent_sets.h"

#include <gtest/gtest.h>

#include <array>

namespace lumenfarm::relay {
namespace {

wire::Lease lease(std::uint64_t number, std::uint32_t source, std::uint64_t first, std::uint64_t count) {
    return {number, 7, 1, {source, first, count}, 0};
}

/// What a result of the relay's own lease covers.
std::vector<wire::Claim> covered(std::uint32_t source, std::uint64_t first, std::uint64_t count) {
    return {wire::Claim(99, 1, {source, first, count})};
}

TEST(LentSets, AResultMayClaimOfSeveralLeases) {
    LentSets sets;
    sets.add(lease(1, 0, 0, 100));
    sets.add(lease(2, 0, 100, 100));
    sets.add(lease(3, 1, 0, 100));
    const auto claims = sets.claims_of(covered(0, 50, 100));
    ASSERT_TRUE(claims);
    EXPECT_EQ(*claims, (std::vector{wire::Claim(1, 7, {0, 50, 50}), wire::Claim(2, 7, {0, 100, 50})}));
    sets.claim(*claims);
    EXPECT_EQ(sets.left(), 200u);
}

TEST(LentSets, WhatIsNotLentIsNotClaimed) {
    LentSets sets;
    sets.add(lease(1, 0, 0, 100));
    sets.add(lease(2, 0, 150, 100));
    EXPECT_FALSE(sets.claims_of(covered(0, 50, 150))) << "a gap lies between";
    EXPECT_FALSE(sets.claims_of(covered(0, 200, 100))) << "it goes beyond";
    EXPECT_FALSE(sets.claims_of(covered(1, 0, 10))) << "another source";
}

TEST(LentSets, ALeaseThatIsClaimedWholeIsLetGo) {
    LentSets sets;
    sets.add(lease(1, 0, 0, 100));
    sets.claim(*sets.claims_of(covered(0, 0, 60)));
    EXPECT_EQ(sets.in_the_way_of(lease(2, 0, 90, 5)).size(), 1u);
    sets.claim(*sets.claims_of(covered(0, 60, 40)));
    EXPECT_TRUE(sets.empty());
    EXPECT_TRUE(sets.in_the_way_of(lease(2, 0, 90, 5)).empty());
    EXPECT_FALSE(sets.remove(1));
}

TEST(LentSets, ALeaseThatGoesBackTakesWhatIsLeftAlong) {
    LentSets sets;
    sets.add(lease(1, 0, 0, 100));
    sets.add(lease(2, 0, 100, 50));
    sets.claim(*sets.claims_of(covered(0, 0, 30)));
    const auto back = sets.remove(1);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->left, 70u);
    EXPECT_EQ(sets.left(), 50u);
    EXPECT_FALSE(sets.claims_of(covered(0, 30, 10)));
}

TEST(LentSets, ANumberIsOfOneLease) {
    LentSets sets;
    sets.add(lease(1, 0, 0, 100));
    EXPECT_EQ(sets.in_the_way_of(lease(1, 0, 500, 10)).size(), 1u);
    EXPECT_EQ(sets.in_the_way_of(lease(1, 0, 50, 10)).size(), 1u);
    EXPECT_TRUE(sets.in_the_way_of(lease(2, 0, 100, 10)).empty());
}

TEST(LentSets, TellWhichLeasesReachIntoARange) {
    LentSets sets;
    for (std::uint64_t i = 0; i < 5; ++i) sets.add(lease(i + 1, 0, 100 * i, 100));
    sets.add(lease(9, 1, 0, 1'000));
    const auto across = sets.across({0, 199, 102});
    ASSERT_EQ(across.size(), 3u);
    EXPECT_EQ(across.front().lease, 2u);
    EXPECT_EQ(across.back().lease, 4u);
    EXPECT_EQ(sets.mean_count(), 250u);
}

}  // namespace
}  // namespace lumenfarm::relay
