#include "worker/part_shelf.h"

#include "tests/scenes/planned_scene.h"

#include <gtest/gtest.h>

#include <set>

/// Within a memory of so many of the equal parts of one job.
namespace lumenfarm::worker {
namespace {

using testing::PlannedScene;

constexpr std::uint64_t plan_bytes = 1'000;

class PartShelfTest : public ::testing::Test {
protected:
    PartShelfTest() {
        // their cost is what counts, not what is in them
        for (PartFile& part : planned_.plan.parts) part.triangles = 100;
        context_->job = 1;
        context_->plan = make_plan_context(encode_plan(planned_.plan)).value();
    }
    static std::uint64_t bytes_for(std::uint64_t parts) {
        return plan_bytes + parts * (limits::part_bytes + 100 * limits::part_bytes_per_triangle);
    }
    /// Takes what comes next, until nothing does or something would have to go.
    static std::set<std::uint32_t> fill(PartShelf& shelf) {
        std::set<std::uint32_t> brought;
        for (auto next = shelf.next({}); next && next->given_up.empty(); next = shelf.next({})) {
            shelf.put(next->key, nullptr);
            brought.insert(next->key.subspace);
        }
        return brought;
    }

    PlannedScene planned_{8};
    std::shared_ptr<JobContext> context_ = std::make_shared<JobContext>();
};

TEST_F(PartShelfTest, HoldsAllWithoutALimit) {
    PartShelf shelf(std::nullopt);
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    EXPECT_EQ(fill(shelf).size(), 8u);
    EXPECT_EQ(shelf.held(1), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST_F(PartShelfTest, FillsTheMemoryFromAPlaceOfItsOwn) {
    PartShelf first(bytes_for(3), 0), second(bytes_for(3), 6);
    ASSERT_TRUE(first.open(context_, plan_bytes) && second.open(context_, plan_bytes));
    EXPECT_EQ(fill(first), (std::set<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(fill(second), (std::set<std::uint32_t>{0, 6, 7}));
    EXPECT_LT(first.room_triangles(), 100u);
}

TEST_F(PartShelfTest, GivesUpWhatWasUnusedForLongest) {
    PartShelf shelf(bytes_for(3));
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    fill(shelf);
    shelf.use({1, 0});
    const std::vector<PartKey> needed{{1, 5}};
    const auto next = shelf.next(needed);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->key, needed[0]);
    EXPECT_EQ(next->given_up, std::vector<PartKey>(1, PartKey{1, 1}));
    shelf.give_up({1, 1});
    shelf.put({1, 5}, nullptr);
    EXPECT_EQ(shelf.held(1), (std::vector<std::uint32_t>{0, 2, 5}));
    EXPECT_FALSE(shelf.next(needed)) << "there is no room for more";
}

TEST_F(PartShelfTest, WhatEarlierSetsNeedStays) {
    PartShelf shelf(bytes_for(2));
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    fill(shelf);
    EXPECT_FALSE(shelf.next(std::vector<PartKey>{{1, 0}, {1, 1}, {1, 5}})) << "the sets of 0 and 1 come first";
    const auto next = shelf.next(std::vector<PartKey>{{1, 0}, {1, 5}, {1, 1}});
    ASSERT_TRUE(next) << "the set of 1 comes later";
    EXPECT_EQ(next->key, (PartKey{1, 5}));
    EXPECT_EQ(next->given_up, std::vector<PartKey>(1, PartKey{1, 1}));
}

TEST_F(PartShelfTest, JobWhoseLargestPartDoesNotFitIsRefused) {
    PartShelf shelf(bytes_for(1) - 1);
    const auto opened = shelf.open(context_, plan_bytes);
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().sentence.find("8 subspaces"), std::string::npos) << opened.error().sentence;
    EXPECT_FALSE(shelf.has(1));
}

TEST_F(PartShelfTest, ClosedJobMakesRoom) {
    PartShelf shelf(bytes_for(2));
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    fill(shelf);
    shelf.close(1);
    EXPECT_FALSE(shelf.holds({1, 0}));
    const std::vector<PartKey> needed{{1, 5}};
    EXPECT_FALSE(shelf.next(needed)) << "the job is not here any more";
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    EXPECT_EQ(fill(shelf).size(), 2u);
}

}  // namespace
}  // namespace lumenfarm::worker
