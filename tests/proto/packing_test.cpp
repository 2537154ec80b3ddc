#include "proto/packing.h"

#include "common/spectrum/spectrum.h"
#include "proto/messages.h"
#include "tests/scene/sample_scene.h"

#include <gtest/gtest.h>

#include <random>

namespace lumenfarm::wire {
namespace {

const PartId first(12, 3, 0);

/// A scene, and hits on it as a tracer might report them.
class Packing : public testing::Test {
protected:
    Packing() {
        emission_.lights.resize(scene_.lights.size());
        for (auto& light : emission_.lights)
            for (std::size_t bin = 0; bin < wavelength_bins; ++bin)
                light.energy.push_back(static_cast<std::uint32_t>(60'000 + bin));
    }
    std::uint32_t below(std::uint32_t bound) { return static_cast<std::uint32_t>(random_() % bound); }
    std::vector<HitRecord> hits(std::size_t count) {
        std::vector<HitRecord> records(count);
        for (auto& record : records) {
            record.triangle = below(static_cast<std::uint32_t>(scene_.triangles.size()));
            record.b1 = static_cast<std::uint16_t>(below(65'536));
            record.b2 = static_cast<std::uint16_t>(below(65'536u - record.b1));
            record.wavelength = static_cast<std::uint16_t>(below(wavelength_bins));
            record.flags = hit_flags(below(20), below(32), below(2));
        }
        return records;
    }
    std::vector<std::uint32_t> energies(std::size_t count) {
        std::vector<std::uint32_t> ticks(count);
        for (auto& each : ticks) each = below(limits::energy_ticks_max + 1);
        return ticks;
    }
    /// Through the wire: encoded, decoded and checked as the master does.
    template <class Part>
    static Part travelled(const Part& part) {
        const auto frame = encode(part);
        auto message = decode(Part::type, std::span(frame).subspan(limits::frame_header_bytes));
        EXPECT_TRUE(message.has_value());
        return std::get<Part>(std::move(*message));
    }
    LightMap empty_map() const { return LightMap(layout_); }
    void add_records(LightMap& map, const std::vector<ResultHits>& parts, Absorption absorption) const {
        for (const auto& sent : parts) {
            const auto part = travelled(sent);
            ASSERT_TRUE(valid_hits(part, scene_, absorption));
            map.add(emission_, part.light, part.records, part.energies);
        }
    }
    void add_maps(LightMap& map, const std::vector<ResultMap>& parts) const {
        for (const auto& sent : parts) {
            const auto part = travelled(sent);
            ASSERT_TRUE(valid_map(part, map.texels().size(), map.surfaces().size()));
            add_map(part, map.texels(), map.surfaces());
        }
    }
    static void expect_equal(const LightMap& a, const LightMap& b) {
        EXPECT_EQ(a.texels(), b.texels());
        EXPECT_TRUE(a.surfaces() == b.surfaces());
    }

    Scene scene_ = test::sample_scene();
    TexelLayout layout_ = *TexelLayout::make(scene_, 0.01);
    Emission emission_;
    std::mt19937 random_{5};
};

TEST_F(Packing, RecordsAndMapsGiveTheSameBits) {
    for (const auto absorption : {Absorption::analog, Absorption::attenuate}) {
        auto by_records = empty_map(), by_maps = empty_map();
        for (std::uint32_t light = 0; light < scene_.lights.size(); ++light) {
            const auto records = hits(20'000);
            const auto ticks = energies(absorption == Absorption::analog ? 0 : records.size());
            add_records(by_records, pack_hits(first, light, records, ticks, 999), absorption);
            auto of_worker = empty_map();
            of_worker.add(emission_, light, records, ticks);
            add_maps(by_maps, pack_map(first, of_worker.texels(), of_worker.surfaces()));
        }
        expect_equal(by_records, by_maps);
        EXPECT_NE(by_maps.texels(), empty_map().texels());
    }
}

TEST_F(Packing, PartsAreNumberedWithoutGapsAndHoldEverything) {
    const auto records = hits(2'500);
    const auto ticks = energies(records.size());
    const auto parts = pack_hits({12, 3, 7}, 1, records, ticks, 1'000);
    ASSERT_EQ(parts.size(), 3u);
    EXPECT_EQ(parts[2].part, PartId(12, 3, 9));
    EXPECT_EQ(parts[2].records.size(), 500u);
    EXPECT_EQ(parts[2].records.back(), records.back());
    EXPECT_EQ(parts[2].energies.back(), ticks.back());
    EXPECT_TRUE(pack_hits(first, 0, {}, {}, 1).empty());
}

TEST_F(Packing, LargeMapsFallIntoSeveralParts) {
    std::vector<TexelSums> texels(60'000);
    for (std::size_t i = 0; i < texels.size(); i += 2) texels[i] = {10, 5, 5, 5, 1, 1 + i};
    std::vector<SurfaceBatches> surfaces(1);
    surfaces[0][1][31] = {10, 5, 3};
    const auto parts = pack_map(first, texels, surfaces);
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_EQ(parts[0].texels.size(), limits::texel_deltas_per_message_max);
    std::vector<TexelSums> sums(texels.size());
    std::vector<SurfaceBatches> surface_sums(1);
    for (const auto& part : parts) add_map(part, sums, surface_sums);
    EXPECT_EQ(sums, texels);
    EXPECT_EQ(surface_sums[0], surfaces[0]);
}

TEST_F(Packing, HitsAreCountedTheSameInBothPackings) {
    const auto records = hits(5'000);
    auto map = empty_map();
    map.add(emission_, 0, records, {});
    HitCounts by_records, by_maps;
    for (const auto& part : pack_hits(first, 0, records, {}, 700)) by_records += hits_of(part);
    for (const auto& part : pack_map(first, map.texels(), map.surfaces())) by_maps += hits_of(part);
    EXPECT_EQ(by_records, (HitCounts{5'000, 5'000}));
    EXPECT_EQ(by_maps, by_records);
}

TEST_F(Packing, RecordsThatTheSceneDoesNotHaveAreRefused) {
    const ResultHits good(first, 0, hits(3), {});
    EXPECT_TRUE(valid_hits(good, scene_, Absorption::analog));
    EXPECT_FALSE(valid_hits(good, scene_, Absorption::attenuate)) << "energies are missing";
    auto bad = good;
    bad.light = static_cast<std::uint32_t>(scene_.lights.size());
    EXPECT_FALSE(valid_hits(bad, scene_, Absorption::analog));
    bad = good;
    bad.records[1].triangle = static_cast<std::uint32_t>(scene_.triangles.size());
    EXPECT_FALSE(valid_hits(bad, scene_, Absorption::analog));
    bad = good;
    bad.records[2].wavelength = wavelength_bins;
    EXPECT_FALSE(valid_hits(bad, scene_, Absorption::analog));
    EXPECT_FALSE(valid_kept(ResultKept(first, {{bad.records[2], 0, 1}}), scene_));
    EXPECT_FALSE(valid_kept(ResultKept(first, {{good.records[0], 99, 1}}), scene_));
    EXPECT_TRUE(valid_kept(ResultKept(first, {{good.records[0], 0, 1}}), scene_));
}

TEST_F(Packing, MapsThatNoHitsCanGiveAreRefused) {
    const TexelDelta texel{3, 2, 100, 90, 80, 70, 60};
    const SurfaceDelta surface{1, 63, 100, 80, 2};
    const auto valid = [](std::vector<TexelDelta> texels, std::vector<SurfaceDelta> surfaces) {
        return valid_map(ResultMap(first, std::move(texels), std::move(surfaces)), 10, 2);
    };
    EXPECT_TRUE(valid({texel}, {surface}));
    const auto texel_with = [&](auto change) {
        auto bad = texel;
        change(bad);
        return valid({bad}, {surface});
    };
    EXPECT_FALSE(texel_with([](TexelDelta& d) { d.texel = 10; }));
    EXPECT_FALSE(texel_with([](TexelDelta& d) { d.hits = 0; }));
    EXPECT_FALSE(texel_with([](TexelDelta& d) { d.radiant = -1; }));
    EXPECT_FALSE(texel_with([](TexelDelta& d) { d.radiant = 2 * std::int64_t{limits::energy_ticks_max} + 1; }));
    EXPECT_FALSE(texel_with([](TexelDelta& d) { d.x = 203; }));
    EXPECT_FALSE(texel_with([](TexelDelta& d) { d.z = -1; }));
    EXPECT_FALSE(texel_with([](TexelDelta& d) { d.y_squared = std::uint64_t{1} << 40; }));
    const auto surface_with = [&](auto change) {
        auto bad = surface;
        change(bad);
        return valid({texel}, {bad});
    };
    EXPECT_FALSE(surface_with([](SurfaceDelta& d) { d.surface = 2; }));
    EXPECT_FALSE(surface_with([](SurfaceDelta& d) { d.side_batch = 64; }));
    EXPECT_FALSE(surface_with([](SurfaceDelta& d) { d.hits = std::uint64_t{1} << 60; }));
    EXPECT_FALSE(surface_with([](SurfaceDelta& d) { d.y = 203; }));
    EXPECT_FALSE(valid({texel, texel}, {surface})) << "a texel twice";
    auto before = texel;
    before.texel = 2;
    EXPECT_FALSE(valid({texel, before}, {})) << "not ascending";
}

}  // namespace
}  // namespace lumenfarm::wire
