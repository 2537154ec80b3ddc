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
        *other_ = *context_;
        other_->job = 2;
    }
    static std::uint64_t bytes_for(std::uint64_t parts) {
        return plan_bytes + parts * (limits::part_bytes + 100 * limits::part_bytes_per_triangle);
    }
    /// Takes what comes next, until nothing does or something would have to go.
    static std::set<std::uint32_t> fill(PartShelf& shelf) {
        std::set<std::uint32_t> brought;
        for (auto next = shelf.next({}); next && next->given_up.empty(); next = shelf.next({})) {
            shelf.put(next->key, {});
            brought.insert(next->key.subspace);
        }
        return brought;
    }

    PlannedScene planned_{8};
    const std::uint64_t whole_bytes_ =
        plan_bytes + limits::part_bytes + limits::part_bytes_per_triangle * planned_.scene.triangles.size();
    std::shared_ptr<JobContext> context_ = std::make_shared<JobContext>();
    std::shared_ptr<JobContext> other_ = std::make_shared<JobContext>();  ///< another job with the same scene
};

TEST_F(PartShelfTest, SceneThatFitsComesWhole) {
    for (const std::optional<std::uint64_t>& bytes_max :
         {std::optional<std::uint64_t>(), std::optional(whole_bytes_)}) {
        PartShelf shelf(bytes_max);
        ASSERT_TRUE(shelf.open(context_, plan_bytes));
        EXPECT_FALSE(shelf.holds({1, 5}));
        const std::vector<PartKey> needed{{1, 5}};
        ASSERT_TRUE(shelf.next(needed));
        EXPECT_EQ(shelf.next(needed)->key, (PartKey{1, none}));
        EXPECT_EQ(shelf.next(needed)->file, context_->plan->plan.whole);
        EXPECT_EQ(fill(shelf), std::set<std::uint32_t>{none});
        EXPECT_EQ(shelf.held(1), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7}));
        EXPECT_TRUE(shelf.holds({1, 5}));
        EXPECT_FALSE(shelf.next(needed));
    }
}

TEST_F(PartShelfTest, SceneThatJustDoesNotFitComesInParts) {
    PartShelf shelf(whole_bytes_ - 1);
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    EXPECT_EQ(fill(shelf), (std::set<std::uint32_t>{0, 1, 2}));
}

TEST_F(PartShelfTest, PartsOnlyIfSoAsked) {
    PartShelf shelf(std::nullopt, 0, true);
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    EXPECT_EQ(fill(shelf).size(), 8u);
    EXPECT_EQ(shelf.held(1), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST_F(PartShelfTest, WholeSceneGoesForAnotherJobAndComesBackWhenThatIsOver) {
    PartShelf shelf(whole_bytes_ + plan_bytes);
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    fill(shelf);
    ASSERT_TRUE(shelf.open(other_, plan_bytes));
    const std::vector<PartKey> needed{{2, 5}};
    const auto next = shelf.next(needed);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->key, needed[0]);
    EXPECT_EQ(next->given_up, std::vector<PartKey>(1, PartKey{1, none}));
    shelf.give_up({1, none});
    shelf.put({2, 5}, {});
    EXPECT_TRUE(shelf.held(1).empty());
    const std::vector<PartKey> both{{2, 5}, {1, 3}};
    ASSERT_TRUE(shelf.next(both));
    EXPECT_EQ(shelf.next(both)->key, both[1]) << "beside the other there is room for parts only";
    shelf.put({1, 3}, {});
    shelf.close(2);
    const auto again = shelf.next({});
    ASSERT_TRUE(again);
    EXPECT_EQ(again->key, (PartKey{1, none}));
    EXPECT_EQ(again->given_up, std::vector<PartKey>(1, PartKey{1, 3})) << "the whole has it, too";
}

TEST_F(PartShelfTest, PartsChangeToTheWholeOnlyWhereNoOtherJobWantsMemory) {
    PartShelf shelf(2 * whole_bytes_);
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    ASSERT_TRUE(shelf.open(other_, plan_bytes));
    shelf.put({1, 0}, {});
    ASSERT_TRUE(shelf.next({}));
    EXPECT_EQ(shelf.next({})->key, (PartKey{2, none}));
    shelf.put({2, none}, {});
    ASSERT_TRUE(shelf.next({}));
    EXPECT_EQ(shelf.next({})->key, (PartKey{1, 1}));
}

TEST_F(PartShelfTest, WholeSceneInUseStays) {
    PartShelf shelf(whole_bytes_ + plan_bytes + bytes_for(1));
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    fill(shelf);
    ASSERT_TRUE(shelf.open(other_, plan_bytes));
    shelf.put({2, 0}, {});
    shelf.use({1, none});
    const auto next = shelf.next(std::vector<PartKey>{{2, 5}});
    ASSERT_TRUE(next);
    EXPECT_EQ(next->given_up, std::vector<PartKey>(1, PartKey{2, 0}));
    EXPECT_FALSE(shelf.next(std::vector<PartKey>{{1, none}, {2, 0}, {2, 5}})) << "earlier sets need all that is here";
}

TEST_F(PartShelfTest, WholeSceneThatCannotBeHadComesInParts) {
    PartShelf shelf(std::nullopt);
    ASSERT_TRUE(shelf.open(context_, plan_bytes));
    shelf.fail_whole(1);
    EXPECT_EQ(fill(shelf).size(), 8u);
}

TEST_F(PartShelfTest, ClosedJobGivesTheMemoryOfItsWholeSceneBack) {
    PartShelf shelf(whole_bytes_);
    for (int time = 0; time < 3; ++time) {
        ASSERT_TRUE(shelf.open(context_, plan_bytes));
        EXPECT_EQ(fill(shelf), std::set<std::uint32_t>{none});
        shelf.close(1);
    }
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
    shelf.put({1, 5}, {});
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
