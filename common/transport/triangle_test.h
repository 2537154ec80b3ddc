#pragma once

#include "common/math/vec.h"
#include "common/transport/clearance.h"

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

/// The meeting of the line with the triangle. `meets` is false where the line passes outside or along the plane.
inline TriangleMeeting meet_triangle(const TriangleRecord& triangle, Vec3d origin, Vec3d direction) {
    const Vec3d a = triangle.corners[0].as<double>() - origin;
    const EdgeVolumes e = edge_volumes(a, triangle.corners[1].as<double>() - origin,
                                       triangle.corners[2].as<double>() - origin, direction);
    const double volume = e.e0 + e.e1 + e.e2;
    if (!e.inside() || volume == 0) return {};
    const Vec3d normal = unit_normal(triangle);
    const double approach = dot(normal, direction);
    if (approach == 0) return {};
    const double scale = 1 / volume;
    return {dot(normal, a) / approach, e.e1 * scale, e.e2 * scale, true};
}

/// The point with these barycentric weights: it lies on the triangle, however far the ray came.
inline Vec3d point_on(Vec3d corner0, Vec3d corner1, Vec3d corner2, double b1, double b2) {
    return corner0 * (1 - b1 - b2) + corner1 * b1 + corner2 * b2;
}

}  // namespace lumenfarm
