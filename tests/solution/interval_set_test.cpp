#include "common/solution/interval_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace lumenfarm {
namespace {

using Intervals = std::vector<IntervalSet::Interval>;

TEST(IntervalSet, TouchingIntervalsBecomeOne) {
    IntervalSet set;
    EXPECT_TRUE(set.insert(10, 20));
    EXPECT_TRUE(set.insert(30, 40));
    EXPECT_TRUE(set.insert(20, 30));
    EXPECT_EQ(set.intervals(), (Intervals{{10, 40}}));
    EXPECT_EQ(set.size(), 30u);
}

TEST(IntervalSet, OverlapsAndEmptyRangesAreRefusedAndChangeNothing) {
    IntervalSet set;
    ASSERT_TRUE(set.insert(10, 20));
    for (const auto& [begin, end] : Intervals{{10, 20}, {5, 11}, {19, 25}, {12, 13}, {0, 100}, {7, 7}, {9, 8}})
        EXPECT_FALSE(set.insert(begin, end)) << begin << ".." << end;
    EXPECT_EQ(set.intervals(), (Intervals{{10, 20}}));
    EXPECT_EQ(set.size(), 10u);
}

TEST(IntervalSet, AgreesWithABitmapOverRandomRanges) {
    std::mt19937 random(7);
    IntervalSet set;
    std::vector<bool> there(200);
    for (int i = 0; i < 2'000; ++i) {
        const auto begin = random() % 200, end = begin + random() % 12;
        if (end > 200) continue;
        bool any = false, all = true;
        for (auto k = begin; k < end; ++k) {
            any = any || there[k];
            all = all && there[k];
        }
        EXPECT_EQ(set.overlaps(begin, end), any);
        EXPECT_EQ(set.covers(begin, end), all);
        Intervals gaps;
        for (auto k = begin; k < end; ++k) {
            if (there[k]) continue;
            if (gaps.empty() || gaps.back().end != k) gaps.push_back({k, k});
            gaps.back().end = k + 1;
        }
        EXPECT_EQ(set.gaps(begin, end), gaps);
        const bool inserted = i % 3 == 0 && set.insert(begin, end);
        EXPECT_EQ(inserted, i % 3 == 0 && !any && begin < end);
        for (auto k = begin; inserted && k < end; ++k) there[k] = true;
        const bool erased = i % 6 == 1 && set.erase(begin, end);
        EXPECT_EQ(erased, i % 6 == 1 && all && begin < end);
        for (auto k = begin; erased && k < end; ++k) there[k] = false;
    }
    EXPECT_EQ(set.size(), static_cast<std::uint64_t>(std::count(there.begin(), there.end(), true)));
    for (std::size_t i = 1; i < set.intervals().size(); ++i)
        EXPECT_LT(set.intervals()[i - 1].end, set.intervals()[i].begin);
}

}  // namespace
}  // namespace lumenfarm
