#include "common/solution/hit_work.h"

#include "tests/scenes/scene_builder.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

namespace lumenfarm {
namespace {

double sum_of(const std::vector<SpreadWork>& work) {
    return std::accumulate(work.begin(), work.end(), 0.0,
                           [](double sum, const SpreadWork& each) { return sum + each.work; });
}

TEST(HitWork, IsEveryHit) {
    JobSpec spec;
    spec.particles = 20'000;
    const LoadedRun run = test::traced_run(testing::mixed_room(), spec);
    EXPECT_EQ(sum_of(hit_work(run.scene, run.layout, run.solution.texels)),
              static_cast<double>(run.solution.balance.hits));
}

/// Each hit lies in the box of its texel, and no box is larger than it has to be.
TEST(HitWork, LiesWhereTheHitsAre) {
    Scene scene;
    scene.positions = {{0, 0, 0}, {3, 0, 0}, {0, 2, 1}};
    scene.triangles = {{0, 1, 2}};
    scene.surfaces.push_back({"tilted", "tilted", 0, 1, 0});
    const TexelLayout layout = TexelLayout::of_rows({5}, {0}, 1).value();
    std::mt19937 random(3);
    for (int i = 0; i < 2'000; ++i) {
        HitRecord hit;
        hit.b1 = static_cast<std::uint16_t>(random() % 65'536);
        hit.b2 = static_cast<std::uint16_t>(random() % (65'536 - hit.b1));
        hit.flags = hit_flags(0, 0, random() % 2);
        std::vector<TexelSums> texels(layout.texel_count());
        texels[layout.texel_of(hit)].hits = 1;
        const auto work = hit_work(scene, layout, texels);
        ASSERT_EQ(work.size(), 1u);
        const Box& box = work[0].box;
        const double b1 = (hit.b1 + 0.5) / 65'536, b2 = (hit.b2 + 0.5) / 65'536;
        const Vec3d at{3 * b1, 2 * b2, b2};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_GE(at[axis], box.low[axis] - 1e-4);
            EXPECT_LE(at[axis], box.high[axis] + 1e-4);
        }
        EXPECT_NEAR(box.high.x - box.low.x, 3.0 / 5, 1e-6);
        EXPECT_NEAR(box.high.y - box.low.y, 2.0 / 5, 1e-6);
        EXPECT_NEAR(box.high.z - box.low.z, 1.0 / 5, 1e-6);
    }
}

TEST(HitWork, PlannedWorkCountsAsSomeHits) {
    const Scene scene = testing::mixed_room();
    const WeightedOctree octree = make_weighted_octree(scene, {}, std::vector<double>(scene.lights.size(), 1));
    EXPECT_NEAR(sum_of(corrected_work(planned_work(octree), {})), planned_hits, 1e-6 * planned_hits);
    const std::vector<SpreadWork> measured{{octree.octree().box(Octree::root()), 500}};
    EXPECT_NEAR(sum_of(corrected_work(planned_work(octree), measured)), planned_hits + 500, 1);
}

}  // namespace
}  // namespace lumenfarm
