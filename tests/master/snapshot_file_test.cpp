#include "master/snapshot_file.h"

#include "common/scene/scene_file.h"
#include "common/solution/solution_file.h"
#include "master/job_log.h"
#include "tests/simulation/small_scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include <memory>
#include <vector>

namespace lumenfarm {
namespace {

/// A job of which nothing is committed, and 30 flights of subspace 2 are in flight, of which ten have ended.
class SnapshotFile : public ::testing::Test {
protected:
    SnapshotFile() {
        JobSpec spec;
        spec.strategy = Strategy::subspaces;
        spec.subspaces = 8;
        prepared_ = prepare_job(spec, scene_bytes_).value();
        const std::size_t subspaces = prepared_->sources() - prepared_->particles.size();
        flights_ = FlightQueues(subspaces);
        ended_.resize(subspaces);
        times_.costs.resize(subspaces);
        times_.costs[3] = {40, 12'000};
        times_.lessons.push_back({prepared_->subspaces->partition(), {1, 2, 0.5, 1, 1, 1, 8, 0.125}});
        solution_ = encode_solution(JobSums(spec, prepared_).take(scene_)).bytes;
        for (std::uint32_t i = 0; i < 3; ++i) flights_.file(2, FlightQueues::Flights(10, flight(i)));
        EXPECT_TRUE(ended_[2].insert(5, 15));
        flights_.remove(2, 5, 10);
    }
    static wire::FlightRecord flight(std::uint32_t particle) {
        Flight flight;
        flight.direction = {0, -1, 0};
        flight.particle = particle;
        flight.energy = flight.start_energy = 7;
        return wire::pack_flight(flight, 0);
    }
    std::vector<std::byte> bytes() const {
        return encode_snapshot(solution_, prepared_->subspaces->partition(), times_, flights_, ended_);
    }
    Result<JobSnapshot> read(std::span<const std::byte> bytes) const {
        return decode_snapshot(bytes, *prepared_, scene_);
    }

    std::vector<std::byte> scene_bytes_ = encode_scene(testing::small_scene());
    Digest scene_ = scene_digest(scene_bytes_);
    std::shared_ptr<const PreparedJob> prepared_;
    FlightQueues flights_;
    std::vector<IntervalSet> ended_;
    WorkTimes times_;
    std::vector<std::byte> solution_;
};

TEST_F(SnapshotFile, FlightsComeBackUnderTheirNumbers) {
    const auto snapshot = read(bytes());
    ASSERT_TRUE(snapshot) << snapshot.error().sentence;
    EXPECT_EQ(snapshot->flights.filed(2), 30u);
    EXPECT_EQ(snapshot->flights.energy(), 20 * 7);
    EXPECT_EQ(snapshot->flights.at(2, 15, 15), flights_.at(2, 15, 15));
    EXPECT_EQ(snapshot->flights.at(2, 0, 5), flights_.at(2, 0, 5));
    EXPECT_EQ(snapshot->ended[2].intervals(), ended_[2].intervals());
    EXPECT_EQ(snapshot->flights.filed(0), 0u);
    EXPECT_EQ(snapshot->cut, prepared_->subspaces->partition());
    EXPECT_EQ(snapshot->work_times, times_);
}

TEST_F(SnapshotFile, NumbersOfFlightsThatHaveAllEndedAreNotGivenAgain) {
    flights_.remove(2, 0, 5);
    flights_.remove(2, 15, 15);
    ASSERT_TRUE(ended_[2].insert(0, 5) && ended_[2].insert(15, 30));
    auto snapshot = read(bytes());
    ASSERT_TRUE(snapshot) << snapshot.error().sentence;
    EXPECT_EQ(snapshot->flights.file(2, {flight(9)}).first, 30u);
}

TEST_F(SnapshotFile, SolutionAloneIsASnapshotWithNothingInFlight) {
    const auto snapshot = read(solution_);
    ASSERT_TRUE(snapshot) << snapshot.error().sentence;
    EXPECT_EQ(snapshot->flights.subspaces(), flights_.subspaces());
    EXPECT_EQ(snapshot->flights.energy(), 0);
}

TEST_F(SnapshotFile, DamagedBytesAreRefused) {
    const auto good = bytes();
    for (std::size_t size = 0; size < good.size(); size += 61) EXPECT_FALSE(read(std::span(good).first(size))) << size;
    for (std::size_t at = 0; at < good.size(); at += 61) {
        auto bad = good;
        bad[at] ^= std::byte{4};
        EXPECT_FALSE(read(bad)) << at;
    }
}

TEST_F(SnapshotFile, LessonsThatCannotBeAreRefused) {
    const CutLesson good = times_.lessons.front();
    const Partition two = Subspaces::cut({{0, 0, 0}, {1, 1, 1}}, {}, 2).partition();
    for (const CutLesson& bad :
         {CutLesson{two, good.times}, CutLesson{good.cut, {1, 1}}, CutLesson{good.cut, {1, 2, 0.5, 1, 1, 1, 8.1, 1}},
          CutLesson{good.cut, {1, std::nan(""), 1, 1, 1, 1, 1, 1}}}) {
        times_.lessons = {good, bad};
        EXPECT_FALSE(read(bytes()));
    }
    times_.lessons.assign(limits::cut_lessons_max + 1, good);
    EXPECT_FALSE(read(bytes()));
    times_.lessons.pop_back();
    EXPECT_TRUE(read(bytes()));
}

TEST(SnapshotRule, ASnapshotPaysWhenMuchCameSinceTheLast) {
    const SnapshotRule rule{.results_max = 100, .times_sums = 8, .bytes_beside_sums = 1'000'000};
    EXPECT_FALSE(rule.pays(0, 0, 0)) << "nothing came";
    EXPECT_TRUE(rule.pays(1, 0, 0));
    EXPECT_FALSE(rule.pays(100, 7'999, 1'000));
    EXPECT_TRUE(rule.pays(100, 8'000, 1'000));
    EXPECT_FALSE(rule.pays(1, 10'999'999, 10'000'000)) << "of large sums not many times as much";
    EXPECT_TRUE(rule.pays(1, 11'000'000, 10'000'000));
    EXPECT_TRUE(rule.pays(101, 1, 10'000'000)) << "many results are many rows";
}

TEST(SnapshotRule, TheFirstSnapshotMakesRoomWhenResultsAreMoreThanIt) {
    EXPECT_FALSE(SnapshotRule::makes_room_in_time(1'000, 1'000, 0, 1'000, 0)) << "it takes as much as it frees";
    EXPECT_TRUE(SnapshotRule::makes_room_in_time(1'001, 1'000, 0, 1'001, 0));
    EXPECT_TRUE(SnapshotRule::makes_room_in_time(5'000, 1'000, 0, 7'000, 7'999));
    EXPECT_FALSE(SnapshotRule::makes_room_in_time(5'000, 1'000, 0, 7'000, 8'000)) << "what is coming leaves it room";
}

TEST(SnapshotRule, ALaterSnapshotMakesRoomWithAnyResult) {
    EXPECT_FALSE(SnapshotRule::makes_room_in_time(0, 1'000, 600, 0, 0)) << "nothing came";
    EXPECT_TRUE(SnapshotRule::makes_room_in_time(1, 1'000, 600, 1, 603));
    EXPECT_FALSE(SnapshotRule::makes_room_in_time(1, 1'000, 600, 1, 604));
    EXPECT_TRUE(SnapshotRule::makes_room_in_time(900, 1'000, 600, 900, 1'899)) << "it is no larger than the sums";
    EXPECT_FALSE(SnapshotRule::makes_room_in_time(900, 1'000, 600, 900, 1'900));
}

}  // namespace
}  // namespace lumenfarm
