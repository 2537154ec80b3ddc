#include "master/learned_cut.h"

#include "common/scene/scene_file.h"
#include "master/job_sums.h"
#include "tests/simulation/small_scene.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

namespace lumenfarm {
namespace {

class LearnedCuts : public ::testing::Test {
protected:
    LearnedCuts() {
        spec_.strategy = Strategy::subspaces;
        spec_.subspaces = 6;
        prepared_ = prepare_job(spec_, encode_scene(testing::small_scene())).value();
    }
    const Partition& planned() const { return prepared_->subspaces->partition(); }
    Vec3d anywhere() {
        const Box& root = prepared_->subspaces->root();
        const Vec3d size = root.high - root.low;
        const auto part = [&] { return std::uniform_real_distribution<double>(0, 1)(random_); };
        return {root.low.x + size.x * part(), root.low.y + size.y * part(), root.low.z + size.z * part()};
    }

    JobSpec spec_;
    std::shared_ptr<const PreparedJob> prepared_;
    std::mt19937_64 random_{5};
};

TEST_F(LearnedCuts, ShareOutWhatThePlanDidNotExpect) {
    std::vector<TexelSums> texels(prepared_->layout.texel_count());
    const WorkTimes unknown;
    EXPECT_DOUBLE_EQ(learn_cut(*prepared_, planned(), texels, unknown, 1).evenness.now, 1) << "nothing is known";
    // all hits are on one triangle
    const std::uint64_t first = prepared_->layout.first_texel(0, 0), last = prepared_->layout.first_texel(0, 1);
    for (std::uint64_t texel = first; texel < last; ++texel) texels[texel].hits = 1'000'000;
    const LearnedCut learned = learn_cut(*prepared_, planned(), texels, unknown, 1);
    EXPECT_GT(learned.evenness.now, 1.5);
    EXPECT_LT(learned.evenness.learned, learned.evenness.now);
    EXPECT_TRUE(learned.evenness.is_worth_a_cut(1.25));
    EXPECT_EQ(learned.cut.subspaces(), planned().subspaces());
    const LearnedCut again = learn_cut(*prepared_, learned.cut, texels, unknown, 1);
    EXPECT_DOUBLE_EQ(again.evenness.now, learned.evenness.learned);
    EXPECT_FALSE(again.evenness.is_worth_a_cut(1.25)) << "the same hits teach nothing new";
}

TEST_F(LearnedCuts, ShareOutTheTimeThatHitsTookOnceTheyAreEven) {
    std::vector<TexelSums> texels(prepared_->layout.texel_count());
    for (TexelSums& texel : texels) texel.hits = 100'000;
    WorkTimes times{{}, std::vector<SubspaceCost>(planned().subspaces(), {1'000'000, 1'000'000'000})};
    times.costs[2].nanoseconds *= 10;
    const WorkTimes unknown;
    const Partition by_hits = learn_cut(*prepared_, planned(), texels, unknown, 1).cut;
    const LearnedCut first = learn_cut(*prepared_, planned(), texels, times, 1);
    EXPECT_EQ(first.cut, by_hits);
    EXPECT_FALSE(first.lesson) << "of the plan only hits count";
    const LearnedCut by_time = learn_cut(*prepared_, by_hits, texels, times, 1);
    EXPECT_GT(by_time.evenness.now, 1.5 * learn_cut(*prepared_, by_hits, texels, unknown, 1).evenness.now);
    EXPECT_LT(by_time.evenness.learned, by_time.evenness.now);
    EXPECT_NE(by_time.cut, by_hits);
    ASSERT_TRUE(by_time.lesson);
    EXPECT_EQ(by_time.lesson->cut, by_hits);
    EXPECT_GT(by_time.lesson->times[2], 2);
}

TEST_F(LearnedCuts, AddUpWhatResultsSayOfSubspaces) {
    JobSums sums(spec_, prepared_);
    const auto add = [&](std::vector<SubspaceWork> work) {
        StagedResult result(1, 1);
        result.add(spec_, *prepared_, wire::ResultWork({1, 1, 0}, std::move(work)));
        sums.merge(result);
    };
    add({{0, 10, 500'000'000}, {4, 1, 1'000'000}});
    add({{4, 2, 1'000'000'000}});
    EXPECT_EQ(sums.work_times().costs[0].hits, 10u);
    EXPECT_EQ(sums.work_times().costs[0].nanoseconds, 500'000'000u);
    EXPECT_EQ(sums.work_times().costs[4].hits, 3u);
    EXPECT_EQ(sums.work_times().costs[4].nanoseconds, 1'001'000'000u);
    sums.file_by(planned(), {});
    EXPECT_TRUE(sums.work_times().lessons.empty());
    const CutLesson lesson{planned(), std::vector<double>(6, 1)};
    sums.file_by(planned(), lesson);
    EXPECT_EQ(sums.work_times().lessons, (std::vector{lesson}));
    EXPECT_EQ(sums.work_times().costs[0].hits, 0u) << "another cut has other subspaces";
}

TEST_F(LearnedCuts, RefuseWorkThatCannotBe) {
    StagedResult nowhere(1, 1);
    nowhere.add(spec_, *prepared_, wire::ResultWork({1, 1, 0}, {{planned().subspaces(), 0, 1}}));
    EXPECT_NE(nowhere.fault().find("of 6"), std::string::npos) << nowhere.fault();
    StagedResult too_many(1, 1);
    too_many.add(spec_, *prepared_, wire::ResultWork({1, 1, 0}, {{0, 1, 1}}));
    const auto complete = too_many.complete(*prepared_, wire::ResultDone(1, 1, {}, 1, {}, 0, 0));
    ASSERT_FALSE(complete);
    EXPECT_NE(complete.error().sentence.find("the work is of 1 hits"), std::string::npos) << complete.error().sentence;
}

TEST_F(LearnedCuts, FileEveryFlightWhereItIs) {
    const std::size_t subspaces = prepared_->subspaces->all().size();
    FlightQueues flights(subspaces);
    std::vector<IntervalSet> ended(subspaces);
    for (std::uint32_t i = 0; i < 500; ++i) {
        Flight flight;
        flight.origin = anywhere();
        flight.direction = normalize(anywhere() - flight.origin);
        flight.travelled_m = 0.1;
        flight.particle = i;
        flight.energy = flight.start_energy = i + 1;
        const std::uint32_t at = planned().at(flight.origin, flight.direction, flight.travelled_m).subspace;
        flights.file(at, {wire::pack_flight(flight, 0)});
    }
    // some have ended
    for (std::uint32_t subspace = 0; subspace < subspaces; ++subspace) {
        if (flights.filed(subspace) < 3) continue;
        ended[subspace].insert(1, 3);
        flights.remove(subspace, 1, 2);
    }
    std::uint64_t left = 0;
    for (std::uint32_t s = 0; s < subspaces; ++s) left += flights.filed(s) - ended[s].size();
    const std::int64_t energy = flights.energy();
    JobSums sums(spec_, prepared_);
    Solution none = JobSums(spec_, prepared_).take({});
    sums.restore(std::move(none), std::move(flights), std::move(ended),
                 WorkTimes{{}, std::vector<SubspaceCost>(subspaces)});
    const Box& root = prepared_->subspaces->root();
    const Subspaces other =
        Subspaces::cut(root, {{{root.low, root.low + (root.high - root.low) * 0.3}, 1}, {root, 1}}, 6);
    sums.file_by(other.partition(), {});
    std::uint64_t filed = 0;
    for (std::uint32_t subspace = 0; subspace < subspaces; ++subspace) {
        EXPECT_EQ(sums.ended()[subspace].size(), 0u);
        filed += sums.flights().filed(subspace);
        for (const auto& record : sums.flights().at(subspace, 0, sums.flights().filed(subspace))) {
            const Flight flight = wire::unpack_flight(record);
            EXPECT_EQ(other.partition().at(flight.origin, flight.direction, flight.travelled_m).subspace, subspace);
        }
    }
    EXPECT_EQ(filed, left);
    EXPECT_EQ(sums.flights().energy(), energy);
}

}  // namespace
}  // namespace lumenfarm
