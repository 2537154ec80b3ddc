#include "worker/paced/paced_results.h"

#include "common/scene/scene_file.h"
#include "tests/scenes/scene_builder.h"
#include "tests/scratch/folder.h"
#include "worker/trace_slot.h"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <utility>
#include <vector>

/// Results that are put together from stored ones, against results that are traced.
namespace lumenfarm::worker {
namespace {

class PacedResultsTest : public ::testing::Test {
protected:
    static JobSpec spec(Absorption absorption = Absorption::analog) {
        JobSpec spec;
        spec.absorption = absorption;
        spec.texel_m = 0.2;
        return spec;
    }
    Result<std::shared_ptr<const PacedResults>> make(const JobSpec& spec) const {
        return PacedResults::make(bytes_, spec, folder_ / "stored", {});
    }
    wire::JobInfo info(JobSpec spec, Packing packing) const {
        spec.packing = packing;
        return {1, scene_digest(bytes_), bytes_.size(), spec, 0.2, 2};
    }
    /// As a worker that traces reports the ranges.
    Parcel traced(const JobSpec& spec, Packing packing, const std::vector<ParticleRange>& ranges) const {
        const auto job = tracing_jobs({})(info(spec, packing), bytes_).value();
        TraceSlot slot({[] { return 0.0; }, [] { return 0.0; }});
        Parcel all;
        for (const ParticleRange& range : ranges) {
            slot.begin({job, 7, 1, range, 0});
            std::optional<SlotReport> report;
            while (!(report && report->set_finished)) report = slot.advance(SlotAsk::nothing);
            if (!report->result) report = slot.advance(SlotAsk::close);
            for (const LightHits& of : report->result->hits) all.add_hits(of.light, of.records, of.energies);
            all.balance += report->result->balance;
            all.texels = std::move(report->result->texels);
            all.surfaces = std::move(report->result->surfaces);
        }
        return all;
    }
    static std::vector<wire::Claim> claims(const std::vector<ParticleRange>& ranges) {
        std::vector<wire::Claim> all;
        for (const ParticleRange& range : ranges) all.emplace_back(7, 1, range);
        return all;
    }

    Parcel put_together(const PacedResults& results, const std::vector<ParticleRange>& ranges) const {
        Parcel parcel;
        results.add_sums(claims(ranges), parcel);
        return parcel;
    }

    testing::Folder folder_;
    std::vector<std::byte> bytes_ = encode_scene(testing::mixed_room());
};

TEST_F(PacedResultsTest, SumsOfAStoredRangeAreThoseOfATrace) {
    const auto results = make(spec());
    ASSERT_TRUE(results) << results.error().sentence;
    for (const ParticleRange& range : {ParticleRange{0, 0, 1'024}, ParticleRange{0, 5, 3}, ParticleRange{0, 1'000, 48},
                                       ParticleRange{0, 1'023, 9'000}, ParticleRange{1, 2'048, 4'096}}) {
        const Parcel stored = put_together(**results, {range});
        const Parcel expected = traced(spec(), Packing::maps, {range});
        EXPECT_EQ(stored.texels, expected.texels) << range.first << " + " << range.count;
        EXPECT_EQ(stored.surfaces, expected.surfaces);
        EXPECT_EQ(stored.balance, expected.balance);
        EXPECT_TRUE(stored.balance.closed());
    }
}

TEST_F(PacedResultsTest, HitsOfAStoredRangeAreThoseOfATrace) {
    for (const Absorption absorption : {Absorption::analog, Absorption::attenuate}) {
        const testing::Folder other;
        const auto results = PacedResults::make(bytes_, spec(absorption), other / "stored", {});
        ASSERT_TRUE(results) << results.error().sentence;
        Parcel stored;
        (*results)->add_hits({1, 1'500, 3'000}, stored);
        const Parcel expected = traced(spec(absorption), Packing::records, {{1, 1'500, 3'000}});
        ASSERT_EQ(stored.hits.size(), 1u);
        ASSERT_EQ(expected.hits.size(), 1u);
        EXPECT_EQ(stored.balance, expected.balance);
        // in blocks or in slices: the order of hits carries no meaning
        const auto sums = [&](const Parcel& parcel) {
            const auto job = (*results)->context_of(info(spec(absorption), Packing::maps)).value();
            LightMap map = job->empty_map();
            map.add(job->emission(), 1, parcel.hits[0].records, parcel.hits[0].energies);
            Parcel summed;
            move_sums(map, summed);
            return summed.texels;
        };
        EXPECT_EQ(sums(stored), sums(expected));
    }
}

TEST_F(PacedResultsTest, BehindTheStoredParticlesTheyComeAgain) {
    const auto results = make(spec());
    ASSERT_TRUE(results) << results.error().sentence;
    const std::uint64_t stored = (*results)->stored_particles();
    const Parcel around = put_together(**results, {{0, 3 * stored - 100, 2 * stored + 300}});
    const Parcel parts = put_together(**results, {{0, 0, stored}, {0, 0, stored}, {0, stored - 100, 100}, {0, 0, 200}});
    EXPECT_EQ(around.texels, parts.texels);
    EXPECT_EQ(around.surfaces, parts.surfaces);
    EXPECT_EQ(around.balance, parts.balance);
    EXPECT_EQ(around.balance.particles, 2 * stored + 300);
    Parcel hits;
    (*results)->add_hits({0, stored - 100, 300}, hits);
    EXPECT_EQ(hits.balance.particles, 300u);
}

TEST_F(PacedResultsTest, FewerAreStoredOfManyLights) {
    Scene scene = testing::mixed_room();
    for (int i = 0; i < 60; ++i) scene.lights.push_back(scene.lights.back());
    bytes_ = encode_scene(scene);
    const auto results = make(spec());
    ASSERT_TRUE(results) << results.error().sentence;
    const std::uint64_t stored = (*results)->stored_particles();
    EXPECT_EQ(stored, 16'384u);
    EXPECT_EQ(put_together(**results, {{60, 0, 3 * stored}}).balance,
              put_together(**results, {{60, 0, stored}, {60, 0, stored}, {60, 0, stored}}).balance);
}

TEST_F(PacedResultsTest, AreTracedOnceAndKept) {
    ASSERT_TRUE(make(spec()));
    const auto scene = make_scene_context(bytes_, {}, &TracerScene::make).value();
    const StoredJob job{scene_digest(bytes_), spec()};
    const auto kept = StoredHits::read(folder_ / "stored", *scene->tracer, job);
    ASSERT_TRUE(kept) << kept.error().sentence;
    EXPECT_EQ(*kept, StoredHits::trace(*scene->tracer, job));
    JobSpec other = spec();
    other.seed = 2;
    const auto refused = make(other);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().sentence.find("another job"), std::string::npos) << refused.error().sentence;
}

/// Blocks without a hit have no message of hits.
TEST_F(PacedResultsTest, LightsThatMissEverythingAreStoredToo) {
    Scene scene = testing::mixed_room();
    Light lost = scene.lights.back();
    lost.name = "lost";
    lost.kind = LightKind::spot;
    lost.surface = none;
    lost.position = {0, 1'000, 0};
    lost.direction = {0, 1, 0};
    lost.cos_inner = 0.99;
    lost.cos_outer = 0.98;
    scene.lights.push_back(lost);
    bytes_ = encode_scene(scene);
    ASSERT_TRUE(make(spec()));
    const auto again = make(spec());
    ASSERT_TRUE(again) << again.error().sentence;
    EXPECT_EQ((*again)->hits_per_particle(static_cast<std::uint32_t>(scene.lights.size() - 1)), 0);
}

TEST_F(PacedResultsTest, ADamagedFileIsRefused) {
    ASSERT_TRUE(make(spec()));
    const auto size = std::filesystem::file_size(folder_ / "stored");
    for (const std::uintmax_t at : {std::uintmax_t{40}, size / 2, size - 1}) {
        std::fstream file(folder_ / "stored", std::ios::in | std::ios::out | std::ios::binary);
        file.seekg(static_cast<std::streamoff>(at));
        const auto byte = static_cast<char>(file.get());
        file.seekp(static_cast<std::streamoff>(at));
        file.put(static_cast<char>(byte ^ 1));
        file.close();
        EXPECT_FALSE(make(spec())) << at;
        file.open(folder_ / "stored", std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(static_cast<std::streamoff>(at));
        file.put(byte);
    }
    EXPECT_TRUE(make(spec()));
    std::filesystem::resize_file(folder_ / "stored", size / 3);
    EXPECT_FALSE(make(spec()));
}

TEST_F(PacedResultsTest, JobsOfOtherHitsOrTexelsAreRefused) {
    const auto results = make(spec());
    ASSERT_TRUE(results) << results.error().sentence;
    EXPECT_TRUE((*results)->context_of(info(spec(), Packing::maps)));
    EXPECT_TRUE((*results)->context_of(info(spec(), Packing::records)));
    EXPECT_FALSE((*results)->context_of(info(spec(Absorption::attenuate), Packing::maps)));
    wire::JobInfo other = info(spec(), Packing::maps);
    other.texel_m = 0.1;
    EXPECT_FALSE((*results)->context_of(other));
    other = info(spec(), Packing::records);
    other.scene.bytes[0] ^= 1;
    EXPECT_FALSE((*results)->context_of(other));
    JobSpec subspaces = spec();
    subspaces.strategy = Strategy::subspaces;
    EXPECT_FALSE(make(subspaces));
    JobSpec keeping = spec();
    keeping.keep_hits = 10;
    EXPECT_FALSE(make(keeping));
}

}  // namespace
}  // namespace lumenfarm::worker
