#pragma once

#include "common/math/vec.h"

#include <array>
#include <cstdint>

/// The exact half of a ray query: which triangle a ray meets is decided here, in double, from the float corners.
namespace lumenfarm {

/// What tracing needs of a triangle, in one cache line.
struct alignas(64) TriangleRecord {
    std::array<Vec3f, 3> corners;
    std::uint32_t surface = 0;
    Vec3d normal;  ///< unit, of the front
};
static_assert(sizeof(TriangleRecord) == 64);

struct TriangleMeeting {
    double distance = 0;  ///< in units of the direction's length
    double b1 = 0, b2 = 0;
    bool meets = false;
};

/// Signed volumes of the ray's line with the three edges. cross() is antisymmetric to the bit, so two triangles that
/// share an edge agree on which side of it the line passes: no line slips between them, whatever the instruction set.
struct EdgeVolumes {
    double e0, e1, e2;
    bool inside() const { return (e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0); }
};

inline EdgeVolumes edge_volumes(const TriangleRecord& triangle, Vec3d origin, Vec3d direction) {
    const Vec3d a = triangle.corners[0].as<double>() - origin;
    const Vec3d b = triangle.corners[1].as<double>() - origin;
    const Vec3d c = triangle.corners[2].as<double>() - origin;
    return {dot(direction, cross(b, c)), dot(direction, cross(c, a)), dot(direction, cross(a, b))};
}

/// The meeting of the line with the triangle. `meets` is false where the line passes outside or along the plane.
inline TriangleMeeting meet_triangle(const TriangleRecord& triangle, Vec3d origin, Vec3d direction) {
    const EdgeVolumes e = edge_volumes(triangle, origin, direction);
    const double volume = e.e0 + e.e1 + e.e2;
    const double approach = dot(triangle.normal, direction);
    if (!e.inside() || volume == 0 || approach == 0) return {};
    const double distance = dot(triangle.normal, triangle.corners[0].as<double>() - origin) / approach;
    const double scale = 1 / volume;
    return {distance, e.e1 * scale, e.e2 * scale, true};
}

/// The point with these barycentric weights: it lies on the triangle, however far the ray came.
inline Vec3d point_on(const TriangleRecord& triangle, double b1, double b2) {
    return triangle.corners[0].as<double>() * (1 - b1 - b2) + triangle.corners[1].as<double>() * b1 +
           triangle.corners[2].as<double>() * b2;
}

}  // namespace lumenfarm
