#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "common/solution/triangle_index.h"
#include "common/transport/hit.h"

#include <cstdint>
#include <optional>
#include <vector>

/// A point of a surface and its surroundings on the same plane: where estimates of light are made.
namespace lumenfarm {

struct SurfacePoint {
    Vec3d position;
    Vec3d normal;  ///< unit, of the side that is asked for
    std::uint32_t triangle = 0;
    std::uint32_t side = 0;  ///< 0: `normal` is that of the triangle's front
};

/// REQUIRES: barycentrics within the triangle.
SurfacePoint point_on_triangle(const Scene& scene, std::uint32_t triangle, double b1, double b2, std::uint32_t side);

/// Where the hit lies [m]: in the middle of what its packed barycentrics stand for.
Vec3d position_of(const Scene& scene, const HitRecord& hit);

/// The nearest surface points to `position` within `tolerance_m`. With a normal: of surfaces that lie across it, the
/// side that faces it; at most one. Without: both sides of the nearest triangle.
std::vector<SurfacePoint> find_surface_points(const Scene& scene, const TriangleIndex& index, Vec3d position,
                                              std::optional<Vec3d> normal, double tolerance_m);

/// A triangle with what estimates ask of it.
struct TriangleFrame {
    TriangleFrame(const Scene& scene, std::uint32_t triangle);
    Vec3d corner, edge1, edge2;  ///< b1 and b2 run along the edges
    Vec3d normal;                ///< unit, front
    double area_m2 = 0;
};

/// The side of the triangle that continues the surface around `point`, or nothing when it belongs to another one. It
/// continues it when it lies in the same plane, or bends away from it by a small angle as the facets of a curved mesh
/// do; the far face of a thin sheet does not, at whatever distance.
std::optional<std::uint32_t> continuing_side(const SurfacePoint& point, const TriangleFrame& frame, double distance_m);

}  // namespace lumenfarm
