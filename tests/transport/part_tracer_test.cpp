#include "common/transport/part_tracer.h"

#include "common/transport/emission.h"
#include "common/transport/emitter.h"
#include "tests/scenes/scene_builder.h"
#include "tests/transport/sorted_hits.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

/// The object-space strategy without a farm: particles go from subspace to subspace until none is on its way.
namespace lumenfarm::testing {
namespace {

WeightedOctree weigh(const Scene& scene) {
    std::vector<double> shares;
    for (const LightEmission& light : make_emission(scene).value().lights) shares.push_back(light.share);
    return make_weighted_octree(scene, {}, shares);
}

struct Parts {
    Parts(const Scene& scene, std::uint32_t count) : subspaces(Subspaces::cut(weigh(scene), count).value()) {
        for (const auto& triangles : subspaces.triangles(scene, part_margin_m(scene_extent(scene))))
            parts.push_back(part_of(scene, triangles));
        for (const ScenePart& part : parts) tracers.push_back(std::move(PartTracer::make(part).value()));
    }
    std::size_t triangles() const {
        std::size_t sum = 0;
        for (const ScenePart& part : parts) sum += part.numbers.size();
        return sum;
    }

    Subspaces subspaces;
    std::vector<ScenePart> parts;
    std::vector<std::unique_ptr<PartTracer>> tracers;
};

/// Particles of all lights, from their emission to their end.
TracedHits trace_in_parts(const Scene& scene, const Parts& parts, const JobSpec& spec, std::uint64_t particles) {
    const Emission emission = make_emission(scene).value();
    const Emitter emitter(scene, emission, parts.subspaces, spec.seed);
    TracedHits hits;
    for (std::uint32_t light = 0; light < scene.lights.size(); ++light) {
        std::vector<std::vector<Flight>> waiting(parts.subspaces.all().size());
        std::vector<Departure> departures;
        emitter.emit({light, 17, particles}, departures, hits.balance);
        for (bool busy = true; busy;) {
            for (const Departure& departure : departures) waiting[departure.subspace].push_back(departure.flight);
            departures.clear();
            busy = false;
            for (std::uint32_t subspace = 0; subspace < waiting.size(); ++subspace) {
                if (waiting[subspace].empty()) continue;
                busy = true;
                const std::vector<Flight> flights = std::exchange(waiting[subspace], {});
                parts.tracers[subspace]->trace(spec, light, flights, parts.subspaces, subspace, hits, departures);
            }
        }
    }
    return hits;
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
    for (const Absorption absorption : {Absorption::analog, Absorption::attenuate}) {
        JobSpec spec;
        spec.absorption = absorption;
        const TracedHits whole = trace_whole(scene, spec, 20'000);
        for (const std::uint32_t count : {1u, 8u, 64u, 200u}) {
            const Parts parts(scene, count);
            const TracedHits together = trace_in_parts(scene, parts, spec, 20'000);
            EXPECT_EQ(together.balance, whole.balance) << count;
            EXPECT_TRUE(sorted(together) == sorted(whole)) << count;
            EXPECT_TRUE(together.balance.closed());
        }
    }
}

TEST(PartTracer, HillsOfManyTrianglesGiveTheSameHitsInParts) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.7), true);
    b.terrain("hills", 150, 0.25f, b.lambert(0.6));
    const std::uint32_t lamp = b.surface("lamp", b.lambert(0.5));
    b.quad({0.4f, 0.99f, 0.4f}, {0.6f, 0.99f, 0.4f}, {0.6f, 0.99f, 0.6f}, {0.4f, 0.99f, 0.6f});
    b.surface_light(lamp, 1000);
    const Scene& scene = b.scene;
    const TracedHits whole = trace_whole(scene, {}, 100'000);
    const Parts parts(scene, 512);
    EXPECT_LT(parts.triangles(), 2 * scene.triangles.size()) << "a part holds little but its own";
    const TracedHits together = trace_in_parts(scene, parts, {}, 100'000);
    EXPECT_EQ(together.balance, whole.balance);
    EXPECT_TRUE(sorted(together) == sorted(whole));
}

TEST(PartTracer, PartWithoutTrianglesLetsEverythingPass) {
    const Scene scene = mixed_room();
    const Subspaces subspaces = Subspaces::cut(weigh(scene), 8).value();
    const Emission emission = make_emission(scene).value();
    std::vector<Departure> emitted, departures;
    EnergyBalance balance;
    Emitter(scene, emission, subspaces, 1).emit({1, 0, 100}, emitted, balance);
    const std::uint32_t subspace = emitted.front().subspace;
    const ScenePart part = part_of(scene, {});
    const auto tracer = std::move(PartTracer::make(part).value());
    TracedHits hits;
    tracer->trace({}, 1, std::vector{emitted.front().flight}, subspaces, subspace, hits, departures);
    EXPECT_TRUE(hits.records.empty());
    const bool escaped = hits.balance.escaped == emitted.front().flight.energy;
    ASSERT_EQ(departures.size(), escaped ? 0u : 1u);
    if (!escaped) {
        EXPECT_NE(departures[0].subspace, subspace);
    }
}

}  // namespace
}  // namespace lumenfarm::testing
