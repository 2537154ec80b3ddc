#include "common/solution/cut_learning.h"

#include "common/support/limits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace lumenfarm {
namespace {

const Box cube{{0, 0, 0}, {1, 1, 1}};

/// Two halves of a unit cube with as much work in each, of which one may take more time than the other.
class TwoHalves : public ::testing::Test {
protected:
    const Subspaces halves_ = Subspaces::cut(cube, {{cube, 1}}, 2);

    LearnedCut learn(std::vector<SubspaceCost> costs, std::vector<CutLesson> lessons = {}, double above = 1) const {
        std::vector<SpreadWork> hits;
        for (int i = 0; i < 1'000; ++i) hits.push_back({{{i / 1e3, 0, 0}, {(i + 1) / 1e3, 1, 1}}, 2e3});
        return learn_cut(halves_, {}, hits, {std::move(lessons), std::move(costs)}, above);
    }
    static double plane_of(const LearnedCut& learned) { return learned.cut.nodes()[0].plane_m; }
};

TEST_F(TwoHalves, MakeTheDearOneSmaller) {
    // a quarter of the hits was measured
    const LearnedCut learned = learn({{250'000, 15'000}, {250'000, 5'000}});
    EXPECT_NEAR(learned.evenness.now, 1.5, 0.01);
    EXPECT_NEAR(learned.evenness.learned, 1, 0.01);
    ASSERT_TRUE(learned.lesson);
    EXPECT_EQ(learned.lesson->cut, halves_.partition());
    // the first lesson goes twice as far: work of 2.25 and 0.25
    EXPECT_NEAR(learned.lesson->times[0], 2.25, 0.01);
    EXPECT_NEAR(plane_of(learned), 0.5 * (2.5 / 2) / 2.25, 0.005);
}

TEST_F(TwoHalves, StayWhereTheyAreEven) {
    const LearnedCut learned = learn({{250'000, 3'000}, {250'000, 3'000}});
    EXPECT_NEAR(learned.evenness.now, 1, 1e-9);
    EXPECT_NEAR(plane_of(learned), 0.5, 1e-6);
}

TEST_F(TwoHalves, AreNotCutAnewWhereTheyAreEvenEnough) {
    const LearnedCut learned = learn({{250'000, 11'000}, {250'000, 9'000}}, {}, 1.25);
    EXPECT_NEAR(learned.evenness.now, 1.1, 0.01);
    EXPECT_EQ(learned.cut, halves_.partition());
    EXPECT_FALSE(learned.lesson);
}

TEST_F(TwoHalves, TeachNothingByFewHits) {
    for (const auto& costs : std::vector<std::vector<SubspaceCost>>{
             {}, {{0, 0}, {0, 0}}, {{100, 1'000'000}, {99, 100}}, {{1'000'000, 0}, {1'000'000, 0}}}) {
        const LearnedCut learned = learn(costs);
        EXPECT_FALSE(learned.lesson);
        EXPECT_DOUBLE_EQ(learned.evenness.now, 1);
        EXPECT_NEAR(plane_of(learned), 0.5, 1e-6);
    }
    // half the work, of which little was measured and that took long, beside little that took its time
    EXPECT_LT(learn({{50, 100'000}, {150, 1'000}}).evenness.now, 1.7);
}

TEST_F(TwoHalves, RememberWhatWasLearnedBefore) {
    const std::vector<CutLesson> before{{halves_.partition(), {3, 1}}};
    EXPECT_NEAR(learn({}, before).evenness.now, 1.5, 1e-9);
    const LearnedCut confirmed = learn({{250'000, 15'000}, {250'000, 5'000}}, before);
    EXPECT_NEAR(confirmed.lesson->times[0], 1, 0.001);
    EXPECT_NEAR(plane_of(confirmed), plane_of(learn({}, before)), 0.001);
}

TEST_F(TwoHalves, TakeEachLessonWithinBounds) {
    const LearnedCut learned = learn({{1'000'000, 1'000'000'000}, {1'000'000, 1}});
    for (const double each : learned.lesson->times) {
        EXPECT_GE(each, 1 / lesson_times_max);
        EXPECT_LE(each, lesson_times_max);
    }
    const std::vector<CutLesson> full(limits::cut_lessons_max, {halves_.partition(), {1, 1}});
    const LearnedCut no_more = learn({{250'000, 15'000}, {250'000, 5'000}}, full);
    EXPECT_FALSE(no_more.lesson) << "after so many none is kept";
    EXPECT_FALSE(no_more.evenness.is_worth_a_cut(1.25));
}

/// Hits on the walls of a cube, near one corner many, and time that is no sum over space: what enters a subspace
/// through its sides takes time, too, and that is more than half of all.
class HitsAndCrossings {
public:
    HitsAndCrossings() {
        std::mt19937_64 random(7);
        std::uniform_real_distribution<double> even(0, 1);
        for (int i = 0; i < 20'000; ++i) {
            Vec3d at{std::pow(even(random), 2), std::pow(even(random), 2), std::pow(even(random), 2)};
            const auto axis = static_cast<std::size_t>(random() % 3);
            at[axis] = random() % 2 == 0 ? 0 : 1;
            hits_.push_back({{at, at}, 10});
        }
    }
    const std::vector<SpreadWork>& hits() const { return hits_; }

    std::vector<SubspaceCost> costs(const Subspaces& cut) const {
        const std::vector<double> shares = cut.shares(hits_);
        std::vector<SubspaceCost> costs;
        for (std::size_t i = 0; i < shares.size(); ++i) {
            const double time_ns = 300 * shares[i] + 3e7 * inner_area(cut.all()[i].box);
            costs.push_back({static_cast<std::uint64_t>(shares[i]), static_cast<std::uint64_t>(time_ns)});
        }
        return costs;
    }

private:
    /// Of its sides, but for those of the cube.
    static double inner_area(const Box& box) {
        const Vec3d size = box.high - box.low;
        double area = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            area += size[(axis + 1) % 3] * size[(axis + 2) % 3] * ((box.low[axis] > 0) + (box.high[axis] < 1));
        return area;
    }

    std::vector<SpreadWork> hits_;
};

TEST(LearnCut, ComesToShareOutTimeThatIsNoSumOverSpace) {
    const HitsAndCrossings model;
    for (const std::uint32_t count : {8u, 16u, 64u}) {
        Subspaces cut = Subspaces::cut(cube, model.hits(), count);
        const auto uneven = [&] {
            std::vector<double> times;
            for (const SubspaceCost& cost : model.costs(cut)) times.push_back(static_cast<double>(cost.nanoseconds));
            return imbalance(times);
        };
        const double by_hits = uneven();
        EXPECT_GT(by_hits, 1.4) << count;
        WorkTimes known;
        for (int cuts = 0; cuts < 12; ++cuts) {
            known.costs = model.costs(cut);
            LearnedCut learned = learn_cut(cut, {}, model.hits(), known, 1);
            EXPECT_NEAR(learned.evenness.now, uneven(), 0.1 * uneven());
            known.lessons.push_back(std::move(*learned.lesson));
            cut = Subspaces::of(cube, std::move(learned.cut));
        }
        EXPECT_LT(uneven(), 1.25) << count << " subspaces, cut by hits: " << by_hits;
    }
}

}  // namespace
}  // namespace lumenfarm
