#include "common/transport/tracer.h"
#include "common/transport/ray_query.h"
#include "tests/scenes/scene_builder.h"
#include "tests/transport/sorted_hits.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lumenfarm::testing {
namespace {

TracedHits trace(const Scene& scene, const JobSpec& spec, ParticleRange range, const std::string& isa = {}) {
    const auto tracer = std::move(TracerScene::make(scene, isa).value());
    TracedHits hits;
    tracer->trace(spec, range, hits);
    return hits;
}

TEST(Tracer, NoInstructionSetChangesAHit) {
    const Scene scene = mixed_room();
    const ParticleRange range{0, 0, 100'000};
    const auto reference = sorted(trace(scene, {}, range, "sse2"));
    EXPECT_GT(reference.size(), 300'000u);
    for (const char* isa : {"sse4.2", "avx", "avx2", "avx512"}) {
        if (std::string(isa) == "avx2" && !__builtin_cpu_supports("avx2")) continue;
        if (std::string(isa) == "avx512" && !__builtin_cpu_supports("avx512vl")) continue;
        EXPECT_TRUE(sorted(trace(scene, {}, range, isa)) == reference) << isa;
    }
}

TEST(Tracer, CuttingARangeChangesNothing) {
    const Scene scene = mixed_room();
    const auto tracer = std::move(TracerScene::make(scene).value());
    for (const Absorption absorption : {Absorption::analog, Absorption::attenuate}) {
        JobSpec spec;
        spec.absorption = absorption;
        TracedHits whole;
        tracer->trace(spec, {1, 100, 5'000}, whole);
        TracedHits parts;
        for (std::uint64_t first = 100; first < 5'100; first += 7)
            tracer->trace(spec, {1, first, std::min<std::uint64_t>(7, 5'100 - first)}, parts);
        EXPECT_TRUE(sorted(parts) == sorted(whole));
        EXPECT_EQ(parts.balance, whole.balance);
    }
}

TEST(Tracer, SeedsAndLightsGiveOtherParticles) {
    const Scene scene = mixed_room();
    JobSpec other;
    other.seed = 2;
    EXPECT_FALSE(sorted(trace(scene, {}, {0, 0, 100})) == sorted(trace(scene, other, {0, 0, 100})));
    EXPECT_FALSE(sorted(trace(scene, {}, {0, 0, 100})) == sorted(trace(scene, {}, {1, 0, 100})));
}

TEST(Tracer, EnergyBalancesToTheTick) {
    const Scene scene = mixed_room();
    for (const CutoffRule rule : {CutoffRule::roulette, CutoffRule::plain}) {
        JobSpec spec;
        spec.absorption = Absorption::attenuate;
        spec.cutoff_rule = rule;
        spec.cutoff = 0.1;
        const TracedHits hits = trace(scene, spec, {0, 0, 20'000});
        EXPECT_TRUE(hits.balance.closed());
        EXPECT_EQ(hits.energies.size(), hits.records.size());
        EXPECT_EQ(hits.balance.particles, 20'000u);
        std::int64_t batches = 0;
        for (const std::int64_t ticks : hits.balance.emitted_by_batch) batches += ticks;
        EXPECT_EQ(batches, hits.balance.emitted);
    }
}

TEST(Tracer, ClosedRoomLosesNoParticle) {
    const Scene scene = mixed_room();
    const TracedHits hits = trace(scene, {}, {1, 0, 300'000});
    EXPECT_EQ(hits.balance.escaped, 0);
    EXPECT_EQ(hits.balance.hits, hits.records.size());
}

TEST(Tracer, SceneWithoutLightIsRefusedWithASentence) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    const auto tracer = TracerScene::make(b.scene);
    ASSERT_FALSE(tracer);
    EXPECT_NE(tracer.error().sentence.find("no light"), std::string::npos);
}

TEST(Tracer, SheetsKeepTheirSidesApart) {
    SceneBuilder b;
    b.surface("sheet", b.lambert(0.5));
    b.quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1});
    b.point_light({0, 1, 0}, 100);
    const TracedHits above = trace(b.scene, {}, {0, 0, 1'000});
    ASSERT_FALSE(above.records.empty());
    for (const HitRecord& hit : above.records) EXPECT_EQ(hit.side(), 0u);
    b.scene.lights[0].position.y = -1;
    const TracedHits below = trace(b.scene, {}, {0, 0, 1'000});
    for (const HitRecord& hit : below.records) EXPECT_EQ(hit.side(), 1u);
}

}  // namespace
}  // namespace lumenfarm::testing
