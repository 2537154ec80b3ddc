#include "common/transport/ray_query.h"
#include "common/math/philox.h"
#include "common/math/sampling.h"
#include "tests/scenes/scene_builder.h"

#include <gtest/gtest.h>

namespace lumenfarm::testing {
namespace {

/// Every triangle in double, ties to the lowest number.
std::uint32_t brute_force(const RayQuery& query, const Ray& ray) {
    std::uint32_t best = none;
    double nearest = 1e300;
    for (std::uint32_t t = 0; t < query.triangles().size(); ++t) {
        if (t == ray.from_triangle) continue;
        const TriangleMeeting m = meet_triangle(query.triangles()[t], ray.origin, ray.direction);
        if (!m.meets || m.distance <= 1e-12 * query.extent().half_m || m.distance >= nearest) continue;
        nearest = m.distance;
        best = t;
    }
    return best;
}

Vec3d random_direction(std::uint32_t i) {
    const auto r = philox(3, {i, 1, 0, 0});
    return sample_uniform_zone(uniform(r[0]), uniform(r[1]), -1, 1);
}

void expect_brute_force_answers(const Scene& scene, std::uint32_t rays) {
    for (const std::string isa : {"sse4.2", ""}) {
        const auto query = RayQuery::make(scene, scene_extent(scene), isa).value();
        for (std::uint32_t i = 0; i < rays; ++i) {
            const auto r = philox(4, {i, 2, 0, 0});
            Ray ray;
            ray.origin = {uniform(r[0]), uniform(r[1]), uniform(r[2])};
            ray.direction = random_direction(i);
            ASSERT_EQ(query->nearest(ray), brute_force(*query, ray)) << "ray " << i << " isa " << query->isa();
        }
    }
}

/// Rays from random points on triangles, as paths have them; every third starts close to an edge.
RayLanes rays_from_triangles(const RayQuery& query, std::uint32_t block) {
    RayLanes rays;
    for (std::uint32_t k = 0; k < lane_count; ++k) {
        const auto r = philox(5, {block, k, 0, 0});
        const auto triangle = static_cast<std::uint32_t>(r[0] % query.triangles().size());
        const TriangleRecord& record = query.triangles()[triangle];
        Barycentrics b = sample_triangle(uniform(r[1]), uniform(r[2]));
        if (k % 3 == 0) b.b2 *= 1e-5;
        const auto corner = [&](std::size_t c) { return record.corners[c].as<double>(); };
        rays.origin.set(k, point_on(corner(0), corner(1), corner(2), b.b1, b.b2));
        rays.direction.set(k, random_direction(static_cast<std::uint32_t>(lane_count) * block + k));
        rays.from_triangle[k] = triangle;
        rays.clear_start[k] = query.clearance().is_clear(record.clearance, b.b1, b.b2) &&
                              std::abs(dot(rays.direction.at(k), unit_normal(record))) >= RayQuery::steep_cosine;
    }
    return rays;
}

void expect_lanes_answer_as_brute_force(const Scene& scene, std::uint32_t blocks) {
    for (const std::string isa : {"sse4.2", ""}) {
        const auto query = RayQuery::make(scene, scene_extent(scene), isa).value();
        std::uint32_t clear_starts = 0;
        MeetingLanes meetings;
        for (std::uint32_t block = 0; block < blocks; ++block) {
            const RayLanes rays = rays_from_triangles(*query, block);
            const std::size_t count = block % 4 == 0 ? 1 + block % lane_count : lane_count;
            query->nearest(rays, count, meetings);
            for (std::size_t k = 0; k < count; ++k) {
                clear_starts += rays.clear_start[k];
                ASSERT_EQ(meetings.triangle[k], brute_force(*query, rays.at(k))) << block << " lane " << k << isa;
                ASSERT_EQ(meetings.triangle[k], query->nearest(rays.at(k)));
            }
        }
        EXPECT_GT(clear_starts, blocks * lane_count / 4);  // both ways were taken
        EXPECT_LT(clear_starts, blocks * lane_count);
    }
}

TEST(RayQuery, LanesAgreeWithDoubleOverAllTriangles) { expect_lanes_answer_as_brute_force(mixed_room(), 200); }

TEST(RayQuery, LanesAgreeWhereSurfacesTouchAndPierce) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.box("block", {0.25f, -0.25f, 0.25f}, {0.75f, 0.5f, 0.75f}, b.lambert(0.5), false);
    b.box("touching", {0.75f, 0, 0.3f}, {0.9f, 0.5f, 0.6f}, b.lambert(0.5), false);
    b.surface("sheet", b.lambert(0.5));
    b.triangle({0.1f, 1e-6f, 0.1f}, {0.1f, 1e-6f, 0.2f}, {0.2f, 1e-6f, 0.1f});
    expect_lanes_answer_as_brute_force(b.scene, 1'000);
}

/// A turned strip of one triangle in front of a sheet, in each order of its corners; rays towards its middle line.
TEST(RayQuery, ThinTrianglesBeforeASheetAreMetWhateverTheirCornersOrder) {
    constexpr std::uint32_t strips = 60;
    for (const double height : {1e-2, 1e-3, 1e-4}) {
        for (std::uint32_t i = 0; i < strips; ++i) {
            const Vec3d along = random_direction(3 * i);
            const Vec3d across = normalize(cross(along, random_direction(3 * i + 1)));
            const Vec3d normal = cross(along, across);
            const std::array<Vec3d, 3> strip{Vec3d{}, along * 3.0, along * (i % 2 == 0 ? 3.0 : 1.5) + across * height};
            const auto corner = [&](std::size_t k) { return strip[(i + k) % 3].as<float>(); };
            SceneBuilder b;
            b.box("room", {-5, -5, -5}, {5, 5, 5}, b.lambert(0.5), true);
            b.surface("strip", b.lambert(0.5));
            b.triangle(corner(0), corner(1), corner(2));
            b.surface("sheet", b.lambert(0.5));
            const Vec3d behind = normal * -2e-4;
            b.triangle((behind - across * 1.0).as<float>(), (behind + along * 3.0 - across * 1.0).as<float>(),
                       (behind + along * 1.5 + across * 1.0).as<float>());
            for (const std::string isa : {"sse4.2", ""}) {
                const auto query = RayQuery::make(b.scene, scene_extent(b.scene), isa).value();
                RayLanes rays;
                for (std::uint32_t k = 0; k < lane_count; ++k) {
                    const double at = (k + 0.5) / lane_count;
                    const Vec3d target = (strip[0] + strip[1]) * (0.5 * at) + strip[2] * (1 - at);
                    const Vec3d slant = random_direction(strips * k + i);
                    rays.direction.set(k, normalize(slant * 0.5 - normal));
                    rays.origin.set(k, target - rays.direction.at(k) * 1.5);
                    rays.from_triangle[k] = none;
                    rays.clear_start[k] = 1;
                }
                MeetingLanes meetings;
                query->nearest(rays, lane_count, meetings);
                for (std::uint32_t k = 0; k < lane_count; ++k) {
                    ASSERT_EQ(meetings.triangle[k], brute_force(*query, rays.at(k))) << height << " " << i << isa;
                    ASSERT_EQ(query->nearest(rays.at(k)), meetings.triangle[k]);
                }
            }
        }
    }
}

TEST(RayQuery, LampsFarAwayMeetWhatTheyAimAt) {
    const Scene scene = mixed_room();
    const auto query = RayQuery::make(scene, scene_extent(scene), "").value();
    for (const double distance_m : {10.0, 1e3, 1e6}) {
        RayLanes rays;
        MeetingLanes meetings;
        for (std::uint32_t block = 0; block < 30; ++block) {
            for (std::uint32_t k = 0; k < lane_count; ++k) {
                const auto r = philox(6, {block, k, 0, 0});
                const Vec3d target{uniform(r[0]), uniform(r[1]), uniform(r[2])};
                const Vec3d direction = random_direction(static_cast<std::uint32_t>(lane_count) * block + k);
                rays.direction.set(k, direction);
                rays.origin.set(k, query->extent().approached(target - direction * distance_m, direction));
                rays.from_triangle[k] = none;
                rays.clear_start[k] = 1;
            }
            query->nearest(rays, lane_count, meetings);
            for (std::uint32_t k = 0; k < lane_count; ++k) {
                ASSERT_LT(length(rays.origin.at(k) - query->extent().centre), 3 * query->extent().half_m);
                ASSERT_EQ(meetings.triangle[k], brute_force(*query, rays.at(k))) << distance_m;
            }
        }
    }
}

TEST(RayQuery, AgreesWithDoubleOverAllTriangles) { expect_brute_force_answers(mixed_room(), 3'000); }

TEST(RayQuery, CoincidentTrianglesGoToTheLowestNumber) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.box("again", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    expect_brute_force_answers(b.scene, 20'000);
}

TEST(RayQuery, InterpenetratingAndTouchingSurfacesAreDecidedInDouble) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.box("block", {0.25f, -0.25f, 0.25f}, {0.75f, 0.5f, 0.75f}, b.lambert(0.5), false);
    b.box("touching", {0.75f, 0, 0.3f}, {0.9f, 0.5f, 0.6f}, b.lambert(0.5), false);
    expect_brute_force_answers(b.scene, 20'000);
}

TEST(RayQuery, SliversAndTinyTrianglesAreMet) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.surface("slivers", b.lambert(0.5));
    for (int i = 0; i < 200; ++i) {
        const float x = 0.3f + 0.002f * static_cast<float>(i);
        b.triangle({x, 0.5f, 0.1f}, {x + 1e-6f, 0.5f, 0.9f}, {x, 0.5f, 0.9f});
        b.triangle({x, 0.4f, 0.5f}, {x + 1e-5f, 0.4f, 0.5f}, {x, 0.4f, 0.5f + 1e-5f});
    }
    expect_brute_force_answers(b.scene, 5'000);
}

TEST(RayQuery, RaysThroughSharedEdgesAndCornersMeetSomething) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.sphere("ball", {0.5f, 0.5f, 0.5f}, 0.3f, 12, b.lambert(0.5));
    const auto query = RayQuery::make(b.scene, scene_extent(b.scene), "").value();
    const Vec3d origin{0.123, 0.877, 0.345};
    for (const Vec3f& corner : b.scene.positions)
        for (const Vec3f& other : {b.scene.positions[0], b.scene.positions[7]}) {
            Ray ray;
            ray.origin = origin;
            ray.direction = normalize((corner.as<double>() + other.as<double>()) * 0.5 - origin);
            EXPECT_NE(query->nearest(ray), none);
        }
}

TEST(RayQuery, WallThatStartsAtTheOriginsEdgeIsNotMissed) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    const auto query = RayQuery::make(b.scene, scene_extent(b.scene), "").value();
    for (const double gap : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
        Ray ray;
        ray.from_triangle = 0;  // of the floor
        // close to the left wall or in front of it, towards it
        ray.origin = {gap, 0, 0.6};
        ray.direction = normalize(Vec3d{-1, 0.5, 0.1});
        EXPECT_EQ(query->triangles()[query->nearest(ray)].surface, 2u) << gap;
    }
}

}  // namespace
}  // namespace lumenfarm::testing
