#include "common/transport/part_tracer.h"

#include "common/transport/scene_in_parts.h"
#include "tests/scenes/scene_builder.h"
#include "tests/transport/sorted_hits.h"
#include "tests/transport/weigh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

/// The object-space strategy without a farm: particles go from subspace to subspace until none is on its way.
namespace lumenfarm::testing {
namespace {

std::unique_ptr<SceneInParts> in_parts(const Scene& scene, std::uint32_t count, std::uint32_t places = 1) {
    return SceneInParts::make(scene, Subspaces::cut(weigh(scene), count).value(), places).value();
}

/// Each look takes a second.
double ticking_s() {
    static double now_s = 0;
    return now_s += 1;
}

/// Particles of all lights, from their emission to their end, of which some leave a place after so many hits.
TracedHits trace_in_parts(const Scene& scene, const SceneInParts& parts, const JobSpec& spec, std::uint64_t particles,
                          WorkMeter* meter = nullptr, std::uint64_t hits_max = limits::hits_per_slice_max) {
    const Emission emission = make_emission(parts.palette.scene).value();
    const Emitter emitter(parts.palette, emission, parts.subspaces.partition(), parts.extent);
    TracedFlights traced;
    for (std::uint32_t light = 0; light < scene.lights.size(); ++light) {
        emitter.emit(spec.seed, {light, 17, particles}, traced.departures, traced.hits.balance);
        for (std::size_t at = 0; !traced.departures.empty(); at = (at + 1) % parts.territories.size()) {
            const std::vector<Departure> arrivals = std::exchange(traced.departures, {});
            parts.territories[at].trace(spec, light, arrivals, hits_max, traced, meter);
            for (const Departure& departure : traced.departures) EXPECT_LE(departure.flight.travelled_m, farthest_m);
        }
    }
    return traced.hits;
}

TracedHits trace_whole(const Scene& scene, const JobSpec& spec, std::uint64_t particles) {
    const auto tracer = std::move(TracerScene::make(scene).value());
    TracedHits hits;
    for (std::uint32_t light = 0; light < scene.lights.size(); ++light)
        tracer->trace(spec, {light, 17, particles}, hits);
    return hits;
}

TEST(PartTracer, SubspacesTogetherGiveTheHitsOfTheWholeScene) {
    const Scene scene = mixed_room();
    constexpr std::uint64_t particles = 4'000;
    for (const auto& [count, places] :
         std::vector<std::pair<std::uint32_t, std::uint32_t>>{{1, 1}, {8, 1}, {8, 8}, {64, 3}, {200, 1}, {200, 200}}) {
        const auto parts = in_parts(scene, count, places);
        for (const Absorption absorption : {Absorption::analog, Absorption::attenuate}) {
            JobSpec spec;
            spec.absorption = absorption;
            const TracedHits whole = trace_whole(scene, spec, particles);
            const TracedHits together = trace_in_parts(scene, *parts, spec, particles);
            EXPECT_EQ(together.balance, whole.balance) << count;
            EXPECT_TRUE(sorted(together) == sorted(whole)) << count;
            EXPECT_TRUE(together.balance.closed());
        }
    }
}

TEST(PartTracer, WhatHasLeftManyHitsGoesOnInAnotherSlice) {
    const Scene scene = mixed_room();
    const auto parts = in_parts(scene, 8);
    const TracedHits whole = trace_whole(scene, {}, 2'000);
    const TracedHits together = trace_in_parts(scene, *parts, {}, 2'000, nullptr, 100);
    EXPECT_EQ(together.balance, whole.balance);
    EXPECT_TRUE(sorted(together) == sorted(whole));

    const Emission emission = make_emission(parts->palette.scene).value();
    const Emitter emitter(parts->palette, emission, parts->subspaces.partition(), parts->extent);
    for (const std::uint64_t hits_max : {0, 1}) {
        TracedFlights traced;
        parts->territories[0].emit({}, {1, 0, 2'000}, emitter, hits_max, traced, nullptr);
        EXPECT_GE(traced.hits.records.size(), hits_max);
        EXPECT_EQ(traced.departures.size() == 2'000, hits_max == 0);
        // one slice through one subspace, or some of which the first hit nothing
        EXPECT_GE(traced.departures.size(), 2'000 - limits::flights_at_once);
        EXPECT_FALSE(traced.hits.balance.closed()) << "energy is still on its way";
    }
}

TEST(PartTracer, WorkIsKnownBySubspace) {
    const Scene scene = mixed_room();
    const auto parts = in_parts(scene, 8, 3);
    WorkMeter meter(ticking_s);
    const TracedHits hits = trace_in_parts(scene, *parts, {}, 1'000, &meter);
    const std::vector<SubspaceWork> work = meter.take();
    std::vector<std::uint64_t> expected(8), measured(8);
    for (const HitRecord& record : hits.records) {
        const auto& corners = scene.triangles[record.triangle];
        const auto at = [&](std::size_t k) { return scene.positions[corners[k]].as<double>(); };
        const double b1 = record.b1 / 65'536.0, b2 = record.b2 / 65'536.0;
        ++expected[parts->subspaces.partition().of(at(0) + (at(1) - at(0)) * b1 + (at(2) - at(0)) * b2)];
    }
    std::uint64_t sum = 0;
    for (const SubspaceWork& each : work) {
        measured.at(each.subspace) = each.hits;
        sum += each.hits;
        EXPECT_GE(each.nanoseconds, 1'000'000'000u) << "it was looked at the clock";
    }
    EXPECT_EQ(sum, hits.balance.hits);
    // hits at bounds are to either side
    for (std::size_t subspace = 0; subspace < 8; ++subspace)
        EXPECT_NEAR(static_cast<double>(measured[subspace]), static_cast<double>(expected[subspace]),
                    30 + 0.03 * static_cast<double>(expected[subspace]));
    EXPECT_TRUE(std::ranges::is_sorted(work, {}, &SubspaceWork::subspace));
    EXPECT_TRUE(meter.take().empty());
}

/// A worker that has memory for all needs no stop at the bounds of subspaces, wherever particles come from.
TEST(PartTracer, OneWithTheWholeSceneTakesOverWhatOthersSendOn) {
    const Scene scene = mixed_room();
    const auto parts = in_parts(scene, 64, 3);
    parts->territories[2] = Territory(TracerScene::make(scene).value());
    EXPECT_TRUE(parts->territories[2].holds(0));
    for (const Absorption absorption : {Absorption::analog, Absorption::attenuate}) {
        JobSpec spec;
        spec.absorption = absorption;
        const TracedHits whole = trace_whole(scene, spec, 20'000);
        const TracedHits together = trace_in_parts(scene, *parts, spec, 20'000);
        EXPECT_EQ(together.balance, whole.balance);
        EXPECT_TRUE(sorted(together) == sorted(whole));
    }
}

TEST(PartTracer, HillsOfManyTrianglesGiveTheSameHitsInParts) {
    const Scene scene = hills_room(150);
    const TracedHits whole = trace_whole(scene, {}, 100'000);
    const auto parts = in_parts(scene, 512, 2);
    EXPECT_LT(parts->triangles, 2 * scene.triangles.size()) << "a part holds little but its own";
    const TracedHits together = trace_in_parts(scene, *parts, {}, 100'000);
    EXPECT_EQ(together.balance, whole.balance);
    EXPECT_TRUE(sorted(together) == sorted(whole));
}

/// A plate in the open under a spot high above: rays run nearly along the planes of cells, and pass the next of them
/// where nothing of the scene can be.
TEST(PartTracer, RaysThatLeaveAnOpenSceneAreFollowedNoFurtherThanItReaches) {
    SceneBuilder b;
    b.surface("plate", b.mirror(0.9));
    b.quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1});
    b.surface("block", b.lambert(0.5));
    b.quad({5, 3, 1}, {5, 4, 1}, {5, 4, -1}, {5, 3, -1});
    b.quad({-5, 3, 1}, {-5, 4, 1}, {-5, 4, -1}, {-5, 3, -1});
    b.point_light({0, 9e6, 0}, 1e12);
    Light& spot = b.scene.lights.back();
    spot.kind = LightKind::spot;
    spot.cos_inner = spot.cos_outer = 1 - 1e-14;
    const Scene& scene = b.scene;
    const TracedHits whole = trace_whole(scene, {}, 20'000);
    ASSERT_GT(whole.records.size(), 0u);
    for (const std::uint32_t places : {1u, 8u}) {
        const auto parts = in_parts(scene, 8, places);
        const TracedHits together = trace_in_parts(scene, *parts, {}, 20'000);
        EXPECT_EQ(together.balance, whole.balance);
        EXPECT_TRUE(sorted(together) == sorted(whole));
    }
}

TEST(PartTracer, PartWithoutTrianglesLetsEverythingPass) {
    const Scene scene = mixed_room();
    const Subspaces subspaces = Subspaces::cut(weigh(scene), 8).value();
    const Emission emission = make_emission(scene).value();
    const SceneExtent extent = scene_extent(scene);
    const ScenePart palette = palette_of(scene);
    std::vector<Departure> emitted, departures;
    EnergyBalance balance;
    Emitter(palette, emission, subspaces.partition(), extent).emit(1, {1, 0, 100}, emitted, balance);
    const std::uint32_t subspace = emitted.front().subspace;
    const auto tracer = std::move(PartTracer::make(part_of(scene, {}), palette.scene, extent).value());
    TracedHits hits;
    tracer->trace({}, 1, std::vector{emitted.front().flight}, subspaces.partition(), subspace, hits, departures);
    EXPECT_TRUE(hits.records.empty());
    const bool escaped = hits.balance.escaped == emitted.front().flight.energy;
    ASSERT_EQ(departures.size(), escaped ? 0u : 1u);
    if (!escaped) {
        EXPECT_NE(departures[0].subspace, subspace);
    }
}

}  // namespace
}  // namespace lumenfarm::testing
