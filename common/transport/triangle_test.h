#pragma once

#include "common/math/vec.h"
#include "common/transport/clearance.h"

#include <algorithm>
#include <array>
#include <cstdint>

/// The exact half of a ray query: which triangle a ray meets is decided here, in double, from the float corners.
namespace lumenfarm {

/// What tracing needs of a triangle, in one cache line.
struct alignas(64) TriangleRecord {
    std::array<Vec3f, 3> corners;
    std::uint32_t surface = 0;
    double per_double_area_m2 = 0;  ///< 1 / |cross(edge1, edge2)|
    Clearance clearance;
    std::uint32_t embree_first = 0;  ///< the corner that is Embree's first (blunt_corner)
};
static_assert(sizeof(TriangleRecord) == 64);

/// From the corners, along the front's normal, as long as twice the area.
inline Vec3d double_area_normal(Vec3d a, Vec3d b, Vec3d c) { return cross(b - a, c - a); }
/// Clear nowhere, and as Embree's first its own first corner.
inline TriangleRecord triangle_record(const Scene& scene, std::uint32_t triangle, std::uint32_t surface) {
    TriangleRecord record;
    for (std::size_t k = 0; k < 3; ++k) record.corners[k] = scene.positions[scene.triangles[triangle][k]];
    record.surface = surface;
    const auto corner = [&](std::size_t k) { return record.corners[k].as<double>(); };
    record.per_double_area_m2 = 1 / length(double_area_normal(corner(0), corner(1), corner(2)));
    return record;
}

/// Of the front, unit.
inline Vec3d unit_normal(const TriangleRecord& triangle) {
    return double_area_normal(triangle.corners[0].as<double>(), triangle.corners[1].as<double>(),
                              triangle.corners[2].as<double>()) *
           triangle.per_double_area_m2;
}

struct TriangleMeeting {
    double distance = 0;  ///< in units of the direction's length
    double b1 = 0, b2 = 0;
    bool meets = false;
};

/// Signed volumes of a ray's line with the three edges of a triangle, from its corners relative to the origin. cross()
/// is antisymmetric to the bit, so two triangles that share an edge agree on which side of it the line passes: no line
/// slips between them, whatever the instruction set.
struct EdgeVolumes {
    double e0, e1, e2;
    bool inside() const { return (e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0); }
};

inline EdgeVolumes edge_volumes(Vec3d a, Vec3d b, Vec3d c, Vec3d direction) {
    return {dot(direction, cross(b, c)), dot(direction, cross(c, a)), dot(direction, cross(a, b))};
}

/// Where along the ray its line meets the triangle's plane, in units of the direction's length: never before the first
/// of the triangle's corners nor behind the last, however flat the ray meets it. REQUIRES: the line meets the triangle,
/// not along its plane.
inline double meeting_distance(const TriangleRecord& triangle, Vec3d origin, Vec3d direction) {
    const auto corner = [&](std::size_t k) { return triangle.corners[k].as<double>() - origin; };
    const Vec3d normal = unit_normal(triangle);
    const double distance = dot(normal, corner(0)) / dot(normal, direction);
    const double unit = 1 / dot(direction, direction);
    const std::array<double, 3> along{dot(corner(0), direction) * unit, dot(corner(1), direction) * unit,
                                      dot(corner(2), direction) * unit};
    return std::clamp(distance, std::min({along[0], along[1], along[2]}), std::max({along[0], along[1], along[2]}));
}

/// The meeting of the line with the triangle. `meets` is false where the line passes outside or along the plane.
inline TriangleMeeting meet_triangle(const TriangleRecord& triangle, Vec3d origin, Vec3d direction) {
    const Vec3d a = triangle.corners[0].as<double>() - origin;
    const EdgeVolumes e = edge_volumes(a, triangle.corners[1].as<double>() - origin,
                                       triangle.corners[2].as<double>() - origin, direction);
    const double volume = e.e0 + e.e1 + e.e2;
    if (!e.inside() || volume == 0) return {};
    if (dot(unit_normal(triangle), direction) == 0) return {};
    const double scale = 1 / volume;
    return {meeting_distance(triangle, origin, direction), e.e1 * scale, e.e2 * scale, true};
}

/// The point with these barycentric weights: it lies on the triangle, however far the ray came.
inline Vec3d point_on(Vec3d corner0, Vec3d corner1, Vec3d corner2, double b1, double b2) {
    return corner0 * (1 - b1 - b2) + corner1 * b1 + corner2 * b2;
}

}  // namespace lumenfarm
