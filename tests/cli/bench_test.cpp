#include "cli/bench/bench_scene.h"
#include "cli/bench/tracer_bench.h"
#include "common/scene/scene_file.h"

#include <gtest/gtest.h>

namespace lumenfarm {
namespace {

TEST(BenchScene, IsAValidSceneOfAboutTheSizeAskedFor) {
    for (const std::uint64_t triangles : {100u, 20'000u}) {
        const Scene scene = make_bench_scene(triangles);
        EXPECT_TRUE(validate(scene));
        EXPECT_NEAR(static_cast<double>(scene.triangles.size()), static_cast<double>(triangles),
                    0.3 * static_cast<double>(triangles));
    }
}

TEST(BenchTracer, FiguresBelongTogether) {
    const auto bench = bench_tracer(make_bench_scene(1'000), 2'000, 3, "");
    ASSERT_TRUE(bench);
    EXPECT_EQ(bench->particles, 2'000u);
    EXPECT_EQ(bench->rounds, 3u);
    EXPECT_FALSE(bench->isa.empty());
    // a closed room: every ray ends in a hit
    EXPECT_NEAR(static_cast<double>(bench->rays), bench->hits_per_particle * 2'000, 1);
    EXPECT_GT(bench->hits_per_particle, 2);
    EXPECT_NEAR(bench->rays_per_s / bench->particles_per_s, bench->hits_per_particle, 1e-6);
    EXPECT_GT(bench->embree_rays_per_s, 0);
    EXPECT_GT(bench->ratio, 0);
}

TEST(BenchTracer, SceneWithoutALightIsRefused) {
    Scene scene = make_bench_scene(100);
    scene.lights.clear();
    const auto bench = bench_tracer(scene, 1'000, 1, "");
    ASSERT_FALSE(bench);
    EXPECT_EQ(bench.error().code, ErrorCode::bad_input);
}

}  // namespace
}  // namespace lumenfarm
