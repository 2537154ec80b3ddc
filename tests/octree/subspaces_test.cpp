#include "common/octree/subspaces.h"

#include "tests/octree/octree_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

namespace lumenfarm {
namespace {

using test::add_triangle;
using test::soup;

constexpr double endless = std::numeric_limits<double>::infinity();

WeightedOctree weigh(const Scene& scene) { return WeightedOctree(Octree::make(scene), {}); }

/// Rays in and about a cube of 10 m: anywhere, along the axes, and along the planes of cells.
class Rays {
public:
    explicit Rays(const Subspaces& subspaces) : subspaces_(subspaces) {}

    struct Ray {
        Vec3d origin, direction;
    };
    Ray next() {
        Ray ray{anywhere(14), normalize(anywhere(2))};
        const auto kind = random_() % 4;
        const std::size_t axis = random_() % 3;
        if (kind == 1) ray.direction[axis] = 0;
        if (kind == 2) ray.direction = axis == 0 ? Vec3d{0, 0, 1} : axis == 1 ? Vec3d{0, -1, 0} : Vec3d{1, 0, 0};
        if (kind >= 2) ray.origin[axis] = subspaces_.all()[random_() % subspaces_.all().size()].box.low[axis];
        return ray;
    }

private:
    Vec3d anywhere(double side) { return Vec3d{uniform(), uniform(), uniform()} * side; }
    double uniform() { return static_cast<double>(random_()) / 2147483648.0 - 0.5; }

    const Subspaces& subspaces_;
    std::minstd_rand random_{7};
};

double most_over_mean(const Subspaces& subspaces) {
    double most = 0, sum = 0;
    for (const Subspace& subspace : subspaces.all()) {
        most = std::max(most, subspace.weight);
        sum += subspace.weight;
    }
    return most * static_cast<double>(subspaces.all().size()) / sum;
}

TEST(Subspaces, AreAsManyAsAskedForAndWeighAlike) {
    const WeightedOctree weighted = weigh(soup(20'000, 10, 0.3f, {}, 5));
    for (const std::uint32_t count : {1u, 2u, 3u, 8u, 14u, 64u, 500u}) {
        const Subspaces subspaces = Subspaces::cut(weighted, count).value();
        EXPECT_EQ(subspaces.all().size(), count);
        EXPECT_EQ(subspaces.partition().subspaces(), count);
        EXPECT_TRUE(Partition::check({subspaces.partition().nodes().begin(), subspaces.partition().nodes().end()}));
        double weight = 0, volume_m3 = 0;
        for (const auto& [box, its_weight] : subspaces.all()) {
            weight += its_weight;
            const Vec3d size = box.high - box.low;
            volume_m3 += size.x * size.y * size.z;
        }
        EXPECT_NEAR(weight, weighted.total_weight(), 1e-9 * weighted.total_weight());
        const Box root = weighted.octree().box(Octree::root());
        EXPECT_NEAR(volume_m3, std::pow(root.high.x - root.low.x, 3), 1e-9 * volume_m3) << "they fill the root";
        EXPECT_LT(most_over_mean(subspaces), 1 + 1e-6) << count;
    }
}

TEST(Subspaces, WeighAlikeWhereAllDetailIsInOneCorner) {
    Scene scene = soup(20'000, 1, 0.05f, {-4, -4, -4}, 6);
    for (unsigned octant = 0; octant < 8; ++octant) {
        const Vec3f at{octant & 1 ? 5.f : -5.f, octant & 2 ? 5.f : -5.f, octant & 4 ? 5.f : -5.f};
        add_triangle(scene, at, at + Vec3f{0.2f, 0, 0}, at + Vec3f{0, 0.2f, 0.1f});
    }
    EXPECT_LT(most_over_mean(Subspaces::cut(weigh(scene), 100).value()), 1 + 1e-6);
}

/// A floor and a wall of many flat boxes, and a crowd of points: none can be parted along every axis.
std::vector<SpreadWork> flat_work() {
    std::vector<SpreadWork> work;
    std::minstd_rand random(11);
    const auto uniform = [&random] { return static_cast<double>(random()) / 2147483648.0; };
    for (int i = 0; i < 3'000; ++i) {
        const double x = uniform() * 9.9, z = uniform() * uniform() * 9.9;
        work.push_back({{{x, 0, z}, {x + 0.1, 0, z + 0.1}}, uniform()});
        work.push_back({{{4, x, z}, {4, x + 0.1, z + 0.1}}, uniform()});
        work.push_back({{{7, 8, z}, {7, 8, z}}, uniform()});
    }
    return work;
}

TEST(Subspaces, OfFlatWorkWeighAlikeToo) {
    const Box root{{-1, -1, -1}, {11, 11, 11}};
    for (const std::uint32_t count : {2u, 7u, 64u, 200u}) {
        const Subspaces subspaces = Subspaces::cut(root, flat_work(), count);
        EXPECT_EQ(subspaces.all().size(), count);
        EXPECT_LT(most_over_mean(subspaces), 1.1) << count;
        const auto shares = subspaces.shares(flat_work());
        EXPECT_LT(imbalance(shares), 1.3) << count << ", by the middles of the boxes";
        EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 4'500, 200);
    }
}

/// Rays meet a flat thing now on this side of a plane through it, now on that.
TEST(Subspaces, AreNotCutAlongFlatWork) {
    const Box root{{0, 0, 0}, {1, 2, 1}};
    for (const double sheet_m : {1.0, 1.0001}) {
        const SpreadWork sheet{{{0, sheet_m, 0}, {1, sheet_m, 1}}, 1};
        const Subspaces halves = Subspaces::cut(root, {{root, 90}, sheet}, 2);
        const Partition::Node& node = halves.partition().nodes()[0];
        EXPECT_EQ(node.which, 1u);
        EXPECT_NEAR(node.plane_m, sheet_m, 0.002);
        EXPECT_GT(std::abs(node.plane_m - sheet_m), 0.0002);
        EXPECT_NEAR(most_over_mean(halves), 1, 0.02);
    }
}

/// What is small in all directions is not flat, and has to be parted however small it is.
TEST(Subspaces, WeighAlikeWhereAllWorkIsInATinyPlace) {
    const Box root{{0, 0, 0}, {1, 1, 1}};
    const auto cube = [](Vec3d at, double side) { return SpreadWork{{at, at + Vec3d{side, side, side}}, 1}; };
    std::vector<SpreadWork> grid;
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 20; ++j)
            for (int k = 0; k < 20; ++k)
                grid.push_back(cube(Vec3d{0.3, 0, 0.7} + Vec3d(i, j, k) * (1.0 / 8192), 1.0 / 8192));
    for (const auto& work : {std::vector{cube({0.123, 0.4, 0}, 1e-4)}, grid}) {
        const Subspaces subspaces = Subspaces::cut(root, work, 64);
        EXPECT_LT(most_over_mean(subspaces), 1.1);
        for (const Subspace& subspace : subspaces.all())
            for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_LT(subspace.box.low[axis], subspace.box.high[axis]);
    }
}

TEST(Subspaces, OfNoWorkAreCutAllTheSame) {
    const Box root{{0, 0, 0}, {1, 2, 3}};
    const Subspaces subspaces = Subspaces::cut(root, {}, 5);
    EXPECT_EQ(subspaces.all().size(), 5u);
    EXPECT_DOUBLE_EQ(imbalance(subspaces.shares({})), 1);
}

TEST(Subspaces, OfOneEvenBoxHaveEqualVolumes) {
    const Box root{{0, 0, 0}, {4, 2, 1}};
    const Subspaces subspaces = Subspaces::cut(root, {{root, 1}}, 6);
    for (const auto& [box, work] : subspaces.all()) {
        const Vec3d size = box.high - box.low;
        EXPECT_NEAR(size.x * size.y * size.z, 8.0 / 6, 1e-9);
    }
}

TEST(Partition, FindsTheSubspaceOfAPointAsOfARayThatBeginsThere) {
    const Subspaces subspaces = Subspaces::cut(weigh(soup(20'000, 10, 0.3f, {}, 5)), 64).value();
    Rays rays(subspaces);
    for (int i = 0; i < 5'000; ++i) {
        const Vec3d origin = rays.next().origin;
        EXPECT_EQ(subspaces.partition().of(origin), subspaces.partition().at(origin, {1, 1, 1}, 0).subspace);
    }
}

TEST(Partition, TakesForeignNodesOnlyWhereTheyAreATree) {
    using Node = Partition::Node;
    constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Node> three{{0.5, 1, 0}, {0, none, 0}, {0.25, 3, 2}, {0, none, 1}, {0, none, 2}};
    ASSERT_TRUE(Partition::check(three));
    EXPECT_EQ(Partition::check(three).value().subspaces(), 3u);
    EXPECT_FALSE(Partition::check({})) << "nothing";
    const auto refused = [&](std::size_t node, const Node& other) {
        std::vector<Node> nodes = three;
        nodes[node] = other;
        return !Partition::check(nodes);
    };
    EXPECT_TRUE(refused(2, {0.25, 1, 2})) << "two parents of one child";
    EXPECT_TRUE(refused(0, {0.5, 0, 0})) << "its own child";
    EXPECT_TRUE(refused(0, {0.5, 2, 0})) << "halves out of step";
    EXPECT_TRUE(refused(2, {0.25, 5, 2})) << "children beyond the end";
    EXPECT_TRUE(refused(2, {0.25, 3, 3})) << "no axis";
    EXPECT_TRUE(refused(2, {nowhere, 3, 2}));
    EXPECT_TRUE(refused(2, {1e300, 3, 2}));
    EXPECT_TRUE(refused(3, {0, none, 2})) << "a subspace twice";
    EXPECT_TRUE(refused(2, {0, none, 1})) << "nodes that nobody has";
}

TEST(Subspaces, RefusesCountsThatTheOctreeCannotGive) {
    const WeightedOctree weighted = weigh(soup(100, 10, 0.3f, {}, 5));
    const auto none_at_all = Subspaces::cut(weighted, 0);
    ASSERT_FALSE(none_at_all);
    EXPECT_EQ(none_at_all.error().code, ErrorCode::bad_input);
    const auto leaves = static_cast<std::uint32_t>(weighted.total_weight());
    EXPECT_EQ(Subspaces::cut(weighted, leaves).value().all().size(), leaves);
    const auto too_many = Subspaces::cut(weighted, leaves + 1);
    ASSERT_FALSE(too_many);
    EXPECT_NE(too_many.error().sentence.find(std::to_string(leaves)), std::string::npos) << too_many.error().sentence;
}

TEST(Subspaces, StretchesOfARayFollowEachOtherInsideTheirCells) {
    const WeightedOctree weighted = weigh(soup(20'000, 10, 0.3f, {}, 5));
    const Subspaces subspaces = Subspaces::cut(weighted, 64).value();
    const Box root = weighted.octree().box(Octree::root());
    constexpr double slack = 1e-12;
    Rays rays(subspaces);
    std::size_t stretches = 0;
    for (int i = 0; i < 20'000; ++i) {
        const auto [origin, direction] = rays.next();
        for (Stretch at = subspaces.partition().at(origin, direction, 0);; ++stretches) {
            ASSERT_GT(at.leaves, at.enters);
            if (at.leaves == endless) break;
            const Box& box = subspaces.all()[at.subspace].box;
            const Vec3d middle = origin + direction * (0.5 * (at.enters + at.leaves));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (middle[axis] < root.low[axis])
                    ASSERT_EQ(box.low[axis], root.low[axis]);
                else if (middle[axis] > root.high[axis])
                    ASSERT_EQ(box.high[axis], root.high[axis]);
                else
                    ASSERT_TRUE(middle[axis] >= box.low[axis] - slack && middle[axis] <= box.high[axis] + slack);
            }
            const double left = at.leaves;
            at = subspaces.partition().at(origin, direction, left);
            ASSERT_EQ(at.enters, left);
        }
    }
    EXPECT_GT(stretches, 50'000u);
}

/// The distance at which a ray meets a triangle's plane inside the triangle, in double, or none.
std::optional<double> distance_to(const Scene& scene, std::uint32_t triangle, Vec3d origin, Vec3d direction) {
    const auto corner = [&](std::size_t k) {
        return scene.positions[scene.triangles[triangle][k]].as<double>() - origin;
    };
    const Vec3d a = corner(0), b = corner(1), c = corner(2);
    const double e0 = dot(direction, cross(b, c)), e1 = dot(direction, cross(c, a)), e2 = dot(direction, cross(a, b));
    if (!((e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0))) return {};
    const Vec3d normal = normalize(cross(b - a, c - a));
    const double approach = dot(normal, direction);
    if (std::abs(approach) < 1e-6) return {};
    return dot(normal, a) / approach;
}

TEST(Subspaces, HoldTheTrianglesThatRaysMeetInThem) {
    const Scene crowd = soup(20'000, 10, 0.3f, {}, 5);
    const Subspaces subspaces = Subspaces::cut(weigh(crowd), 64).value();
    // among the crowd, which leaves no cell empty, large triangles, some of them in the planes between cells
    Scene scene = soup(300, 8, 6, {}, 8);
    for (const Subspace& subspace : subspaces.all()) {
        const Vec3f at = subspace.box.low.as<float>();
        add_triangle(scene, at, at + Vec3f{0, 1, 0}, at + Vec3f{0, 0, 1.5f});
        add_triangle(scene, at, at + Vec3f{1, 0, 0}, at + Vec3f{0, 0, 1.5f});
    }
    const auto filed = subspaces.triangles(scene, 1e-6);
    Rays rays(subspaces);
    std::size_t meetings = 0;
    for (int i = 0; i < 20'000; ++i) {
        const auto [origin, direction] = rays.next();
        for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
            const auto distance = distance_to(scene, t, origin, direction);
            if (!distance || *distance < 0) continue;
            ++meetings;
            const std::uint32_t subspace = subspaces.partition().at(origin, direction, *distance).subspace;
            ASSERT_NE(subspace, none);
            ASSERT_TRUE(std::ranges::binary_search(filed[subspace], t)) << i << " triangle " << t;
        }
    }
    EXPECT_GT(meetings, 10'000u);
    // and not many others
    std::size_t held = 0;
    for (const auto& triangles : filed) held += triangles.size();
    EXPECT_LT(held, filed.size() * scene.triangles.size() / 2);
}

}  // namespace
}  // namespace lumenfarm
