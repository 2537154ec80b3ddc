#include "common/octree/octree.h"

#include "tests/octree/octree_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace lumenfarm {
namespace {

using test::add_triangle;
using test::floor_grid;
using test::soup;

using Corners = std::array<Vec3<long double>, 3>;

Corners corners_of(const Scene& scene, std::uint32_t triangle) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = scene.positions[scene.triangles[triangle][k]].as<long double>();
    return corners;
}

/// True when the axis separates triangle and box by more than `slack` of the axis' scale.
bool separated(const Corners& corners, const Box& box, Vec3<long double> axis, long double slack) {
    const Vec3<long double> centre = (box.low.as<long double>() + box.high.as<long double>()) * 0.5L;
    const Vec3<long double> half = (box.high - box.low).as<long double>() * 0.5L;
    long double low = std::numeric_limits<long double>::infinity(), high = -low, scale = 0;
    for (const Vec3<long double>& corner : corners) {
        const long double p = dot(corner - centre, axis);
        low = std::min(low, p), high = std::max(high, p);
        scale = std::max(scale, length(corner - centre) * length(axis));
    }
    const long double reach = half.x * std::abs(axis.x) + half.y * std::abs(axis.y) + half.z * std::abs(axis.z);
    return low > reach + slack * scale || high < -reach - slack * scale;
}

/// All thirteen separating axes in long double: an oracle that shares nothing with the code under test.
bool overlaps(const Corners& corners, const Box& box, long double slack) {
    const std::array<Vec3<long double>, 3> units{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const std::array<Vec3<long double>, 3> edges{corners[1] - corners[0], corners[2] - corners[1],
                                                 corners[0] - corners[2]};
    if (separated(corners, box, cross(edges[0], edges[1]), slack)) return false;
    for (const auto& unit : units) {
        if (separated(corners, box, unit, 0)) return false;
        for (const auto& edge : edges)
            if (separated(corners, box, cross(unit, edge), slack)) return false;
    }
    return true;
}

struct Checked {
    std::uint64_t leaves = 0, references = 0, needed = 0, deepest = 0;
    double leaf_volume = 0;
};

/// Every triangle stands in every leaf that it overlaps, and in none that its bounding box does not touch.
Checked check_leaves(const Scene& scene, const Octree& octree) {
    Checked checked;
    octree.for_each_cell([&](const OctreeCell& cell) {
        const OctreeNode& node = octree.nodes()[cell.node];
        if (!node.is_leaf()) return;
        const Box box = octree.box(cell);
        const auto have = octree.triangles(node);
        EXPECT_TRUE(std::is_sorted(have.begin(), have.end()));
        for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
            const Corners corners = corners_of(scene, t);
            const bool stands = std::binary_search(have.begin(), have.end(), t);
            if (overlaps(corners, box, 0)) {
                EXPECT_TRUE(stands) << "triangle " << t << " is missing in node " << cell.node;
                ++checked.needed;
            }
            EXPECT_TRUE(!stands || overlaps(corners, box, 5e-3L)) << "triangle " << t << " is far from " << cell.node;
        }
        ++checked.leaves;
        checked.references += node.count;
        checked.deepest = std::max<std::uint64_t>(checked.deepest, cell.depth);
        checked.leaf_volume += std::pow(box.high.x - box.low.x, 3);
    });
    return checked;
}

double volume(const Box& box) { return (box.high.x - box.low.x) * (box.high.y - box.low.y) * (box.high.z - box.low.z); }

class OctreeOfSoup : public testing::TestWithParam<Scene> {};

TEST_P(OctreeOfSoup, LeavesHoldExactlyTheTrianglesThatOverlapThem) {
    const Scene& scene = GetParam();
    OctreeOptions options;
    options.nodes_max = 3'000;  // the check is quadratic
    const Octree octree = Octree::make(scene, options);
    const Checked checked = check_leaves(scene, octree);
    EXPECT_GT(checked.leaves, 100u);
    EXPECT_GE(checked.references, checked.needed);
    EXPECT_LE(static_cast<double>(checked.references), 1.01 * static_cast<double>(checked.needed) + 8);
    EXPECT_NEAR(checked.leaf_volume / volume(octree.box(Octree::root())), 1, 1e-9);
    EXPECT_LE(octree.nodes().size(), options.nodes_max);
}

INSTANTIATE_TEST_SUITE_P(Scenes, OctreeOfSoup,
                         testing::Values(soup(300, 10, 0.5f, {}, 1), soup(60, 1, 3, {0.3f, -7, 2}, 2),
                                         soup(300, 1e6f, 3e4f, {8e6f, -9e6f, 7e6f}, 3),
                                         soup(300, 1e-4f, 1e-5f, {1e-3f, 0, 0}, 4),
                                         soup(300, 10, 0.5f, {5000, 5000, 0}, 5), floor_grid(12)),
                         [](const auto& scene) { return "scene" + std::to_string(scene.index); });

TEST(Octree, CellsAreCubesThatTileTheRootWithSharedBounds) {
    const Scene scene = soup(500, 7, 0.4f, {0.1f, 0.2f, 0.3f}, 9);
    const Octree octree = Octree::make(scene);
    const Box root = octree.box(Octree::root());
    const Box bounds = bounding_box(scene);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_LE(root.low[axis], bounds.low[axis]);
        EXPECT_GE(root.high[axis], bounds.high[axis]);
        EXPECT_EQ(root.high[axis] - root.low[axis], root.high.x - root.low.x);
    }
    octree.for_each_cell([&](const OctreeCell& cell) {
        if (octree.nodes()[cell.node].is_leaf()) return;
        const Box box = octree.box(cell);
        EXPECT_EQ(octree.box(octree.child(cell, 0)).low, box.low);
        EXPECT_EQ(octree.box(octree.child(cell, 7)).high, box.high);
        EXPECT_EQ(octree.box(octree.child(cell, 0)).high, octree.box(octree.child(cell, 7)).low);
    });
}

TEST(Octree, SplitsDownToTheObjectsThatALeafMayHold) {
    Scene scene;  // triangles that stand apart
    for (int i = 0; i < 12 * 12 * 12; ++i) {
        const Vec3f at{static_cast<float>(i % 12), static_cast<float>(i / 12 % 12), static_cast<float>(i / 144)};
        add_triangle(scene, at, at + Vec3f{0.3f, 0, 0.1f}, at + Vec3f{0, 0.3f, 0.2f});
    }
    for (const std::uint32_t leaf_objects : {2u, 4u, 32u}) {
        OctreeOptions options;
        options.leaf_objects = leaf_objects;
        const Octree octree = Octree::make(scene, options);
        std::uint32_t fullest = 0;
        for (const OctreeNode& node : octree.nodes())
            if (node.is_leaf()) fullest = std::max(fullest, node.count);
        EXPECT_LE(fullest, leaf_objects);
        EXPECT_GT(octree.nodes().size(), scene.triangles.size() / leaf_objects);
    }
}

TEST(Octree, SceneOfFewTrianglesIsOneLeaf) {
    const Octree octree = Octree::make(soup(4, 1, 1, {}, 3));
    ASSERT_EQ(octree.nodes().size(), 1u);
    EXPECT_EQ(octree.triangles(octree.nodes()[0]).size(), 4u);
}

TEST(Octree, EmptySceneIsOneEmptyLeaf) {
    const Octree octree = Octree::make(Scene{});
    ASSERT_EQ(octree.nodes().size(), 1u);
    EXPECT_TRUE(octree.nodes()[0].is_empty_leaf());
}

TEST(Octree, TreeDoesNotDependOnThreads) {
    const Scene scene = soup(20'000, 10, 0.2f, {}, 13);
    const Octree one = Octree::make(scene);
    for (const std::uint32_t threads : {2u, 3u, 8u}) {
        OctreeOptions options;
        options.threads = threads;
        const Octree many = Octree::make(scene, options);
        EXPECT_TRUE(std::equal(one.nodes().begin(), one.nodes().end(), many.nodes().begin(), many.nodes().end()));
        EXPECT_TRUE(std::equal(one.items().begin(), one.items().end(), many.items().begin(), many.items().end()));
    }
}

TEST(Octree, DepthAndNodeLimitsHold) {
    const Scene scene = soup(5'000, 10, 0.5f, {}, 17);
    OctreeOptions options;
    for (const std::uint32_t depth : {0u, 1u, 3u, 5u}) {
        options.depth_max = depth;
        std::uint32_t deepest = 0;
        const Octree octree = Octree::make(scene, options);
        octree.for_each_cell([&](const OctreeCell& cell) { deepest = std::max(deepest, cell.depth); });
        EXPECT_EQ(deepest, depth);
    }
    options = {};
    for (const std::uint64_t nodes : {1u, 8u, 9u, 100u, 5'000u}) {
        options.nodes_max = nodes;
        const std::size_t made = Octree::make(scene, options).nodes().size();
        EXPECT_LE(made, nodes);
        EXPECT_GT(2 * made + 8, nodes / 2) << "the limit is used";
    }
}

TEST(Octree, TrianglesThatMeetInACornerAreNotSplitForEver) {
    const Octree octree = Octree::make(floor_grid(100));  // six triangles about every corner
    EXPECT_LT(octree.nodes().size(), 20 * 20'000u);
    std::uint32_t deepest = 0;
    octree.for_each_cell([&](const OctreeCell& cell) { deepest = std::max(deepest, cell.depth); });
    EXPECT_LE(deepest, 10u);
}

TEST(Octree, FloorAtARoundHeightStandsInOneLayerOfCells) {
    const Scene scene = floor_grid(128);
    const Octree octree = Octree::make(scene);
    octree.for_each_cell([&](const OctreeCell& cell) {
        const Box box = octree.box(cell);
        EXPECT_TRUE(box.low.y != 0 && box.high.y != 0) << "a cell ends in the floor";
    });
    EXPECT_LT(octree.items().size(), 8 * scene.triangles.size());
}

TEST(Octree, TrianglesAllAtOnePlaceStayTogetherWithinTheLimits) {
    Scene scene;
    for (int i = 0; i < 20'000; ++i) add_triangle(scene, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const Octree octree = Octree::make(scene);
    for (const OctreeNode& node : octree.nodes())
        EXPECT_TRUE(!node.is_leaf() || node.count == 0 || node.count == 20'000) << node.count;
    EXPECT_LE(octree.items().size(), 32 * 20'000u + 4'096);
    EXPECT_LE(octree.nodes().size(), 16 * 20'000u + 4'096);
}

TEST(Octree, CrowdOfLargeTrianglesStaysWithinTheLimitOfReferences) {
    const Scene scene = soup(3'000, 1, 5, {}, 29);  // each crosses most cells
    const Octree octree = Octree::make(scene);
    EXPECT_LE(octree.items().size(), 32 * 3'000u + 4'096);
    EXPECT_GT(octree.items().size(), 8 * 3'000u) << "the limit is used";
}

TEST(Octree, ClusterInAHugeSceneIsStillResolved) {
    Scene scene = soup(200, 1, 0.02f, {}, 19);
    add_triangle(scene, {900, 900, 900}, {901, 900, 900}, {900, 901, 900});
    const Octree octree = Octree::make(scene);
    std::uint32_t fullest = 0;
    for (const OctreeNode& node : octree.nodes())
        if (node.is_leaf()) fullest = std::max(fullest, node.count);
    EXPECT_LE(fullest, 6u);
}

TEST(Octree, CoordinatesThatFloatsBarelyTellApartEndInALeaf) {
    Scene scene;
    for (int i = 0; i < 50; ++i)
        add_triangle(scene, {1e7f, 1e7f, 1e7f}, {1e7f - 1, 1e7f, 1e7f}, {1e7f, 1e7f - 1, 1e7f});
    const Octree octree = Octree::make(scene);
    EXPECT_GE(octree.items().size(), 50u);
    EXPECT_LT(octree.nodes().size(), 100u);
}

TEST(Octree, LeafOfAPointIsTheLeafWhoseBoxHoldsIt) {
    const Scene scene = soup(1'000, 10, 0.3f, {}, 23);
    const Octree octree = Octree::make(scene);
    octree.for_each_cell([&](const OctreeCell& cell) {
        if (!octree.nodes()[cell.node].is_leaf()) return;
        const Box box = octree.box(cell);
        EXPECT_EQ(octree.leaf_of((box.low + box.high) * 0.5), cell.node);
        EXPECT_EQ(octree.leaf_of(box.low), cell.node) << "the lower bound belongs to the cell";
    });
    const Box root = octree.box(Octree::root());
    EXPECT_NE(octree.leaf_of(root.high), none) << "the root is closed";
    EXPECT_EQ(octree.leaf_of(root.high + Vec3d{1, 0, 0}), none);
    EXPECT_EQ(octree.leaf_of({std::nan(""), 0, 0}), none);
}

}  // namespace
}  // namespace lumenfarm
