#include "common/octree/weighted_octree.h"

#include "tests/octree/octree_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace lumenfarm {
namespace {

using test::add_triangle;
using test::soup;

/// One small triangle near each corner of a cube of 10 m, or only near those of `octants`.
Scene corner_triangles(unsigned octants = 255) {
    Scene scene;
    for (unsigned octant = 0; octant < 8; ++octant) {
        if (!(octants >> octant & 1)) continue;
        const Vec3f at{octant & 1 ? 9.5f : 0.5f, octant & 2 ? 9.5f : 0.5f, octant & 4 ? 9.5f : 0.5f};
        add_triangle(scene, at, at + Vec3f{0.2f, 0, 0}, at + Vec3f{0, 0.2f, 0.1f});
    }
    return scene;
}

Box point(Vec3d p) { return {p, p}; }

WeightedOctree weigh(const Scene& scene, std::vector<LightPlace> lights) {
    return WeightedOctree(Octree::make(scene), lights);
}

TEST(WeightedOctree, LeavesCountOneOrNothingAndParentsSumUp) {
    const WeightedOctree weighted = weigh(soup(3'000, 10, 0.3f, {}, 5), {});
    const auto nodes = weighted.octree().nodes();
    double filled = 0;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].is_leaf()) {
            EXPECT_EQ(weighted.weight(i), nodes[i].is_empty_leaf() ? 0 : 1);
            filled += nodes[i].is_empty_leaf() ? 0 : 1;
            continue;
        }
        double sum = 0;
        for (std::uint32_t child = nodes[i].first; child < nodes[i].first + 8; ++child) sum += weighted.weight(child);
        EXPECT_EQ(weighted.weight(i), sum);
    }
    EXPECT_EQ(weighted.total_weight(), filled);
}

TEST(WeightedOctree, LightOfEightyAddsTenToEachOfEightChildren) {
    const WeightedOctree weighted = weigh(corner_triangles(), {{point({5, 5, 5}), 0}});
    const WeightedOctree lit = weigh(corner_triangles(), {{{{4, 4, 4}, {6, 6, 6}}, 80}});
    ASSERT_EQ(lit.octree().nodes().size(), 9u);
    EXPECT_EQ(lit.light_cells()[0], Octree::root());
    EXPECT_EQ(lit.weight(0), weighted.weight(0) + 80);
    for (std::uint32_t child = 1; child <= 8; ++child) {
        EXPECT_EQ(weighted.weight(child), 1);
        EXPECT_EQ(lit.weight(child), 1 + 10);
    }
}

TEST(WeightedOctree, LightOfEightyInAnOctantGoesToThatOctantsChildren) {
    // the first octant holds eight triangles, one in each of its own octants; the other seven hold one each
    Scene scene = corner_triangles(0xfe);
    const double root_low = Octree::make(corner_triangles()).box(Octree::root()).low.x;
    for (unsigned octant = 0; octant < 8; ++octant) {
        const Vec3f at{octant & 1 ? 4.0f : 0.5f, octant & 2 ? 4.0f : 0.5f, octant & 4 ? 4.0f : 0.5f};
        add_triangle(scene, at, at + Vec3f{0.2f, 0, 0}, at + Vec3f{0, 0.2f, 0.1f});
    }
    const WeightedOctree lit = weigh(scene, {{point({1, 1, 1}), 80}});
    ASSERT_EQ(lit.octree().box(Octree::root()).low.x, root_low);
    const OctreeCell cell = lit.light_cells()[0];
    EXPECT_EQ(cell, lit.octree().child(Octree::root(), 0)) << "the largest cell below the root";
    EXPECT_EQ(lit.weight(cell.node), 8 + 80);
    const std::uint32_t first = lit.octree().nodes()[cell.node].first;
    for (std::uint32_t child = first; child < first + 8; ++child) EXPECT_EQ(lit.weight(child), 1 + 10);
    for (std::uint32_t octant = 1; octant < 8; ++octant)
        EXPECT_EQ(lit.weight(lit.octree().child(Octree::root(), octant).node), 1) << "the others are as they were";
    EXPECT_EQ(lit.total_weight(), 15 + 80);
}

TEST(WeightedOctree, EmptyChildrenGetNothing) {
    const WeightedOctree lit = weigh(corner_triangles(0b10110111), {{{{1, 1, 1}, {9, 9, 9}}, 60}});
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
        const bool filled = 0b10110111 >> octant & 1;
        EXPECT_EQ(lit.weight(1 + octant), filled ? 1 + 10 : 0);
    }
}

TEST(WeightedOctree, WeightGoesDownToTheLeavesInEqualShares) {
    const Scene scene = soup(2'000, 10, 0.3f, {}, 7);
    const WeightedOctree dark = weigh(scene, {});
    const WeightedOctree lit = weigh(scene, {{point({-3, -3, -3}), 1000}, {point({-3, -3, 3}), 500}});
    const auto nodes = lit.octree().nodes();
    // an inner node's extra weight is shared equally among its non-empty children
    for (const OctreeCell& cell : lit.light_cells()) {
        const std::uint32_t first = nodes[cell.node].first;
        std::vector<double> extras;
        for (std::uint32_t child = first; child < first + 8; ++child)
            if (dark.weight(child) > 0) extras.push_back(lit.weight(child) - dark.weight(child));
        for (const double extra : extras) EXPECT_NEAR(extra, extras[0], 1e-9);
    }
    EXPECT_NEAR(lit.total_weight(), dark.total_weight() + 1500, 1e-8);
    for (std::uint32_t i = 0; i < nodes.size(); ++i) EXPECT_EQ(lit.weight(i) == 0, dark.weight(i) == 0);
}

TEST(WeightedOctree, LightInAnEmptyOctantOrOutsideGoesToTheRoot) {
    const Scene scene = corner_triangles(0xfe);
    for (const Vec3d at : {Vec3d{1, 1, 1}, Vec3d{50, 1, 1}}) {
        const WeightedOctree lit = weigh(scene, {{point(at), 70}});
        EXPECT_EQ(lit.light_cells()[0], Octree::root());
        for (std::uint32_t octant = 1; octant < 8; ++octant) EXPECT_EQ(lit.weight(1 + octant), 1 + 10);
    }
}

TEST(WeightedOctree, SceneWithoutTrianglesWeighsNothing) {
    EXPECT_EQ(weigh(Scene{}, {{point({0, 0, 0}), 80}}).total_weight(), 0);
}

TEST(WeightedOctree, LightsWeighByTheirShareOfTheFlux) {
    Scene scene = corner_triangles();
    Light lamp;
    lamp.name = "lamp";
    lamp.kind = LightKind::point;
    lamp.position = {1, 1, 1};
    Light panel;
    panel.name = "panel";
    panel.surface = 0;
    scene.surfaces.push_back({.name = "panel", .object = "", .first_triangle = 7, .triangle_count = 1});
    scene.lights = {lamp, panel};
    const std::vector<double> shares{0.25, 0.75};
    const WeightedOctree weighted = make_weighted_octree(scene, {}, shares);
    EXPECT_EQ(weighted.added_weight(0), 2);
    EXPECT_EQ(weighted.added_weight(1), 6);
    EXPECT_EQ(weighted.weight(1), 1 + 2);
    EXPECT_EQ(weighted.weight(8), 1 + 6);
    EXPECT_EQ(make_weighted_octree(scene, {}, shares, 10).added_weight(1), 60);

    const OctreeSummary summary = summarize(scene, weighted);
    EXPECT_EQ(summary.triangles, 8u);
    EXPECT_EQ(summary.nodes, 9u);
    EXPECT_EQ(summary.leaves, 8u);
    EXPECT_EQ(summary.empty_leaves, 0u);
    EXPECT_EQ(summary.references, 8u);
    EXPECT_EQ(summary.fullest_leaf, 1u);
    EXPECT_EQ(summary.depth, 1u);
    EXPECT_EQ(summary.total_weight, 16);
    EXPECT_EQ(summary.light_weight, 8);
    ASSERT_EQ(summary.lights.size(), 2u);
    EXPECT_EQ(summary.lights[1].light, "panel");
    EXPECT_EQ(summary.lights[1].depth, 1u);
    EXPECT_EQ(summary.lights[1].added_weight, 6);
    EXPECT_EQ(summary.lights[1].cell_weight, 7);
    EXPECT_GT(summary.lights[1].box.low.x, 1);
    EXPECT_EQ(summary.lights[1].box.high.x, summary.root.high.x);
}

}  // namespace
}  // namespace lumenfarm
