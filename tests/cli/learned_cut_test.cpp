#include "cli/import/import.h"
#include "cli/products/inspect_cuts.h"
#include "common/solution/hit_work.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>

/// How evenly subspaces share the work out, before and after it was measured.
namespace lumenfarm {
namespace {

LoadedRun traced(const Scene& scene, std::uint64_t particles, std::uint64_t seed) {
    JobSpec spec;
    spec.particles = particles;
    spec.seed = seed;
    return test::traced_run(scene, spec);
}

WeightedOctree planned(const LoadedRun& run) {
    std::vector<double> shares;
    for (const auto& light : run.emission.lights) shares.push_back(light.share);
    return make_weighted_octree(run.scene, {}, shares);
}

/// What the cut learned from a tenth of a job is worth for the others, beside cuts that have learned nothing.
void expect_learned(const std::string& name, const Scene& scene) {
    const LoadedRun tenth = traced(scene, 100'000, 1), rest = traced(scene, 900'000, 2);
    const WeightedOctree octree = planned(tenth);
    const Box root = octree.octree().box(Octree::root());
    const auto seen = hit_work(tenth.scene, tenth.layout, tenth.solution.texels);
    const auto to_come = hit_work(rest.scene, rest.layout, rest.solution.texels);
    for (const std::uint32_t count : {8u, 16u, 64u}) {
        if (count > Subspaces::most(octree)) continue;
        const auto measured = [&](std::vector<SpreadWork> by) {
            return imbalance(Subspaces::cut(root, std::move(by), count).shares(to_come));
        };
        const double unweighted = measured({{root, 1}}), weighted = measured(planned_work(octree)),
                     learned = measured(corrected_work(planned_work(octree), seen));
        std::cout << name << ", " << count << " subspaces, largest share of the hits over the mean: unweighted "
                  << unweighted << ", planned " << weighted << ", learned " << learned << "\n";
        EXPECT_LE(learned, 1.25) << name << ", " << count;
        EXPECT_LT(learned, unweighted) << name << ", " << count;
    }
}

TEST(LearnedCut, SharesTheWorkOfThePaperRoomOutEvenly) {
    const auto imported = import_scene(std::filesystem::path(LUMENFARM_SOURCE_DIR) / "scenes" / "paper_room.gltf", {});
    ASSERT_TRUE(imported);
    expect_learned("paper room", imported->scene);
}

/// A large room with a lamp at one end and 3,000 small triangles in the far corner.
Scene detail_in_one_corner() {
    const auto imported = import_scene(std::filesystem::path(LUMENFARM_SOURCE_DIR) / "scenes" / "cornell.gltf", {});
    Scene scene = imported->scene;
    const Box box = bounding_box(scene);
    const Vec3d size = box.high - box.low;
    const auto first = static_cast<std::uint32_t>(scene.triangles.size());
    constexpr int side = 40;
    const auto at = [&](int i, int k) {
        const double height = 0.01 * (1 + (i * 7 + k * 13) % 5);
        return Vec3d{box.low.x + size.x * (0.02 + 0.12 * i / side), box.low.y + size.y * (0.02 + height),
                     box.low.z + size.z * (0.02 + 0.12 * k / side)};
    };
    for (int i = 0; i < side; ++i)
        for (int k = 0; k < side; ++k) {
            const auto corner = static_cast<std::uint32_t>(scene.positions.size());
            for (const auto& [a, b] : {std::pair{i, k}, {i + 1, k}, {i, k + 1}, {i + 1, k + 1}})
                scene.positions.push_back(at(a, b).as<float>());
            scene.triangles.push_back({corner, corner + 2, corner + 1});
            scene.triangles.push_back({corner + 1, corner + 2, corner + 3});
        }
    scene.surfaces.push_back(
        {"crumbs", "crumbs", first, static_cast<std::uint32_t>(scene.triangles.size()) - first, 0});
    return scene;
}

TEST(LearnedCut, SharesTheWorkOutEvenlyWhereAllDetailIsInOneCorner) {
    expect_learned("detail in one corner", detail_in_one_corner());
}

TEST(LearnedCut, IsShownByInspect) {
    const auto imported = import_scene(std::filesystem::path(LUMENFARM_SOURCE_DIR) / "scenes" / "paper_room.gltf", {});
    ASSERT_TRUE(imported);
    const LoadedRun run = traced(imported->scene, 50'000, 1);
    const auto cuts = balance_of_cuts(run, planned(run), 16);
    ASSERT_EQ(cuts.size(), 3u);
    for (const CutBalance& cut : cuts) {
        EXPECT_EQ(cut.planned.size(), 16u);
        EXPECT_EQ(cut.measured.size(), 16u);
        EXPECT_NE(cuts_table(cuts).find(cut.name), std::string::npos);
    }
    EXPECT_GT(imbalance(cuts[0].measured), imbalance(cuts[2].measured));
    EXPECT_EQ(cuts_document(cuts).size(), 3u);
}

}  // namespace
}  // namespace lumenfarm
