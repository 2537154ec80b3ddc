#include "worker/paced/paced_slot.h"

#include "common/scene/scene_file.h"
#include "tests/scenes/scene_builder.h"
#include "tests/scratch/folder.h"

#include <gtest/gtest.h>

#include <memory>

/// A slot in which time passes.
namespace lumenfarm::worker {
namespace {

constexpr double pace = 1'024'000;  // a slice a millisecond

class PacedSlotTest : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        bytes_ = encode_scene(testing::mixed_room());
        const testing::Folder folder;
        results_ = PacedResults::make(bytes_, spec(), folder / "stored", {}).value();
    }
    static void TearDownTestSuite() { results_.reset(); }

    static JobSpec spec(Packing packing = Packing::automatic) {
        JobSpec spec;
        spec.packing = packing;
        spec.texel_m = 0.2;
        return spec;
    }
    static SetWork set(Packing packing, std::uint64_t lease, std::uint64_t first, std::uint64_t count) {
        static const auto maps = context(Packing::maps), records = context(Packing::records);
        return {packing == Packing::maps ? maps : records, lease, 1, {0, first, count}, 0};
    }
    static std::shared_ptr<const JobContext> context(Packing packing) {
        return results_->context_of({1, scene_digest(bytes_), bytes_.size(), spec(packing), 0.2, 2}).value();
    }

    static inline std::vector<std::byte> bytes_;
    static inline std::shared_ptr<const PacedResults> results_;
    PacedSlot slot_{results_, pace};
};

TEST_F(PacedSlotTest, ASetTakesWhatItsThreadWouldTake) {
    slot_.begin(set(Packing::maps, 9, 0, 1'024'000));
    slot_.go_on(10);
    EXPECT_DOUBLE_EQ(slot_.stops_s(), 11);
    const SlotReport finished = slot_.stop();
    EXPECT_TRUE(finished.set_finished && finished.open && !finished.set_left);
    EXPECT_FALSE(finished.result) << "maps go on adding";
    const SlotReport closed = slot_.stop(SlotAsk::close);
    ASSERT_TRUE(closed.result && !closed.open);
    EXPECT_EQ(closed.result->claims.at(0), wire::Claim(9, 1, {0, 0, 1'024'000}));
    EXPECT_EQ(closed.result->balance.particles, 1'024'000u);
    EXPECT_DOUBLE_EQ(closed.result->trace_s, 1);
    EXPECT_FALSE(closed.result->texels.empty());
}

TEST_F(PacedSlotTest, AnInterruptIsHeardAfterTheSliceAtHand) {
    slot_.begin(set(Packing::maps, 9, 0, 10'240));
    slot_.go_on(0);
    slot_.interrupt(SlotAsk::close, 0.0025);
    EXPECT_DOUBLE_EQ(slot_.stops_s(), 0.003);
    const SlotReport part = slot_.stop();
    ASSERT_TRUE(part.result && part.set_left && !part.open);
    EXPECT_EQ(part.result->claims.at(0).range, (ParticleRange{0, 0, 3'072}));
    slot_.go_on(5);
    EXPECT_DOUBLE_EQ(slot_.stops_s(), 5.007);
    EXPECT_TRUE(slot_.stop().set_finished);
    EXPECT_EQ(slot_.stop(SlotAsk::close).result->claims.at(0).range, (ParticleRange{0, 3'072, 7'168}));
}

TEST_F(PacedSlotTest, RecordsAreHandedOverWhenFullAndAtTheEndOfTheSet) {
    slot_.begin(set(Packing::records, 9, 0, 1'000'000));
    std::uint64_t particles = 0;
    std::size_t results = 0;
    for (bool finished = false; !finished; ++results) {
        slot_.go_on(0);
        SlotReport report = slot_.stop();
        ASSERT_TRUE(report.result);
        EXPECT_LE(report.result->bytes(), limits::result_close_bytes * 5 / 4);
        EXPECT_EQ(report.result->claims.at(0).range.first, particles);
        particles += report.result->balance.particles;
        finished = report.set_finished;
    }
    EXPECT_EQ(particles, 1'000'000u);
    EXPECT_GT(results, 2u);
}

TEST_F(PacedSlotTest, WhatIsAbandonedIsGone) {
    slot_.begin(set(Packing::maps, 9, 0, 10'240));
    slot_.go_on(0);
    slot_.interrupt(SlotAsk::close, 0.001);
    slot_.interrupt(SlotAsk::abandon, 0.001);
    slot_.interrupt(SlotAsk::close, 0.001);
    const SlotReport left = slot_.stop();
    EXPECT_FALSE(left.result || left.set_left || left.open) << "to throw away outweighs to hand over";
    slot_.begin(set(Packing::maps, 10, 50'000, 1'024));
    slot_.go_on(1);
    EXPECT_TRUE(slot_.stop().set_finished);
    const auto result = slot_.stop(SlotAsk::close).result;
    ASSERT_TRUE(result);
    EXPECT_EQ(result->claims.size(), 1u);
    EXPECT_EQ(result->balance.particles, 1'024u);
}

}  // namespace
}  // namespace lumenfarm::worker
