#include "common/transport/clearance.h"
#include "common/math/philox.h"
#include "common/math/sampling.h"
#include "common/transport/enlarged_triangle.h"
#include "common/transport/near_part.h"
#include "tests/scenes/scene_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lumenfarm::testing {
namespace {

// far larger than in the tracer, so that chance finds points at their limits
constexpr ClearanceRules rules{.reach_m = 0.004, .edge_band_m = 0.008, .enlargement_m = 0.004};

Corners corners_of(const Scene& scene, std::uint32_t triangle) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = scene.positions[scene.triangles[triangle][k]].as<double>();
    return corners;
}

double distance_to_segment(Vec3d p, Vec3d a, Vec3d b) {
    const Vec3d along = b - a;
    const double at = std::clamp(dot(p - a, along) / dot(along, along), 0.0, 1.0);
    return length(p - (a + along * at));
}

double distance_to_triangle(Vec3d p, const Corners& c) {
    const Vec3d normal = cross(c[1] - c[0], c[2] - c[0]);
    bool above = true;
    double nearest = 1e300;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d a = c[k];
        const Vec3d b = c[(k + 1) % 3];
        above = above && dot(cross(b - a, p - a), normal) >= 0;
        nearest = std::min(nearest, distance_to_segment(p, a, b));
    }
    return above ? std::abs(dot(p - c[0], normal)) / length(normal) : nearest;
}

double distance_to_others(const Scene& scene, std::uint32_t triangle, Vec3d p) {
    double nearest = 1e300;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t)
        if (t != triangle) nearest = std::min(nearest, distance_to_triangle(p, corners_of(scene, t)));
    return nearest;
}

/// Of random points on random triangles: the share that is called clear. Each of these must be.
double expect_clear_points_are_clear(const Scene& scene, std::uint32_t points) {
    const ClearanceMap map = ClearanceMap::make(scene, rules);
    std::uint32_t clear = 0;
    for (std::uint32_t i = 0; i < points; ++i) {
        const auto r = philox(7, {i, 0, 0, 0});
        const auto triangle = static_cast<std::uint32_t>(r[0] % scene.triangles.size());
        Barycentrics b = sample_triangle(uniform(r[1]), uniform(r[2]));
        if (i % 4 == 1) b.b1 *= 0.03;  // half of them close to an edge
        if (i % 4 == 3) b.b2 *= 0.03;
        if (!map.is_clear(map.triangles()[triangle], b.b1, b.b2)) continue;
        ++clear;
        const Corners corners = corners_of(scene, triangle);
        // the weights may be those of the triangle itself or of the one that Embree holds
        for (const Corners& c : {corners, enlarged(corners, rules.enlargement_m).corners}) {
            const Vec3d point = c[0] * (1 - b.b1 - b.b2) + c[1] * b.b1 + c[2] * b.b2;
            EXPECT_GT(distance_to_others(scene, triangle, point), rules.reach_m) << "point " << i << " of " << triangle;
        }
    }
    return static_cast<double>(clear) / points;
}

TEST(Clearance, EmptyRoomIsClearUpToItsEdges) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    EXPECT_GT(expect_clear_points_are_clear(b.scene, 20'000), 0.5);
}

TEST(Clearance, BlocksThatTouchAndPierceLeaveTheRestClear) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.box("standing", {0.2f, 0, 0.2f}, {0.4f, 0.3f, 0.4f}, b.lambert(0.5), false);
    b.box("piercing", {0.5f, -0.3f, 0.5f}, {0.9f, 0.4f, 0.8f}, b.lambert(0.5), false);
    EXPECT_GT(expect_clear_points_are_clear(b.scene, 20'000), 0.3);
}

TEST(Clearance, WhatStandsJustInsideAnEdgeWidensItsBand) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.surface("kerb", b.lambert(0.5));
    // 0.0115 m beside the diagonal of the floor, along the longest edge of one of its triangles
    b.quad({0.09f, 0, 0.1063f}, {0.89f, 0, 0.9063f}, {0.89f, 0.2f, 0.9063f}, {0.09f, 0.2f, 0.1063f});
    EXPECT_GT(expect_clear_points_are_clear(b.scene, 50'000), 0.3);
}

TEST(Clearance, CurvedMeshesAreClearWithinTheirFacets) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.sphere("ball", {0.5f, 0.4f, 0.5f}, 0.4f, 10, b.lambert(0.5));  // it touches the floor
    EXPECT_GT(expect_clear_points_are_clear(b.scene, 20'000), 0.1);
}

TEST(Clearance, SheetsWithinReachOfEachOtherAreClearNowhereButBeyond) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.surface("sheet", b.lambert(0.5));
    b.triangle({0.2f, 0.003f, 0.2f}, {0.2f, 0.003f, 0.8f}, {0.8f, 0.003f, 0.2f});
    const ClearanceMap map = ClearanceMap::make(b.scene, rules);
    const Clearance& sheet = map.triangles().back();
    for (std::uint32_t i = 0; i < 1'000; ++i) {
        const auto r = philox(8, {i, 0, 0, 0});
        const Barycentrics weights = sample_triangle(uniform(r[0]), uniform(r[1]));
        EXPECT_FALSE(map.is_clear(sheet, weights.b1, weights.b2));
    }
    EXPECT_GT(expect_clear_points_are_clear(b.scene, 20'000), 0.4);
}

TEST(Clearance, SliversAreClearNowhere) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.surface("sliver", b.lambert(0.5));
    b.triangle({0.3f, 0.5f, 0.1f}, {0.302f, 0.5f, 0.9f}, {0.3f, 0.5f, 0.9f});
    const ClearanceMap map = ClearanceMap::make(b.scene, rules);
    EXPECT_FALSE(map.is_clear(map.triangles().back(), 1.0 / 3, 1.0 / 3));
}

TEST(Clearance, TrianglesAmongVeryManyNeighboursAreClearNowhere) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    const ClearanceRules fine{.reach_m = 1e-6, .edge_band_m = 2e-6, .enlargement_m = 1e-6};
    constexpr int segments = 2'000;
    b.surface("disc", b.lambert(0.5));
    const auto rim = [](int i) {
        const double angle = 2 * std::numbers::pi * i / segments;
        return Vec3d{0.5 + 0.4 * std::cos(angle), 0.5, 0.5 + 0.4 * std::sin(angle)}.as<float>();
    };
    for (int i = 0; i < segments; ++i) b.triangle({0.5f, 0.5f, 0.5f}, rim(i + 1), rim(i));
    const ClearanceMap map = ClearanceMap::make(b.scene, fine);
    for (std::size_t t = 0; t < map.triangles().size(); ++t)
        EXPECT_EQ(map.is_clear(map.triangles()[t], 0.4, 0.3), t < 12) << t;
}

TEST(Clearance, PointLightsAreClearAwayFromSurfaces) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.point_light({0.5, 0.5, 0.5}, 1);
    b.point_light({0.5, 0.001, 0.5}, 1);
    const ClearanceMap map = ClearanceMap::make(b.scene, rules);
    EXPECT_TRUE(map.is_clear_at_light(0));
    EXPECT_FALSE(map.is_clear_at_light(1));
}

}  // namespace
}  // namespace lumenfarm::testing
