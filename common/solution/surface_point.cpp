#include "common/solution/surface_point.h"

#include <cmath>

namespace lumenfarm {
namespace {

constexpr double cos_bend_max = 0.9;  // facets up to 26 degrees apart belong to one curved surface
constexpr double rise_max = 0.45;     // sin of that angle: height above the facet's plane over the distance to it
constexpr double coplanar = 1e-5;     // of the size of the triangle, and in direction
constexpr double across_min = 0.7;    // a surface answers to a normal up to 45 degrees off

double plane_tolerance_m(const TriangleFrame& frame) { return coplanar * (length(frame.edge1) + length(frame.edge2)); }

}  // namespace

TriangleFrame::TriangleFrame(const Scene& scene, std::uint32_t triangle) {
    const Triangle& corners = scene.triangles[triangle];
    corner = scene.positions[corners[0]].as<double>();
    edge1 = scene.positions[corners[1]].as<double>() - corner;
    edge2 = scene.positions[corners[2]].as<double>() - corner;
    const Vec3d across = cross(edge1, edge2);
    const double twice = length(across);
    area_m2 = twice / 2;
    normal = across * (1 / twice);
}

SurfacePoint point_on_triangle(const Scene& scene, std::uint32_t triangle, double b1, double b2, std::uint32_t side) {
    const TriangleFrame frame(scene, triangle);
    return {frame.corner + frame.edge1 * b1 + frame.edge2 * b2, side == 0 ? frame.normal : -frame.normal, triangle,
            side};
}

Vec3d position_of(const Scene& scene, const HitRecord& hit) {
    const TriangleFrame frame(scene, hit.triangle);
    constexpr double step = 1.0 / 65'536;
    return frame.corner + frame.edge1 * ((hit.b1 + 0.5) * step) + frame.edge2 * ((hit.b2 + 0.5) * step);
}

std::vector<SurfacePoint> find_surface_points(const Scene& scene, const TriangleIndex& index, Vec3d position,
                                              std::optional<Vec3d> normal, double tolerance_m) {
    std::vector<std::uint32_t> near;
    index.near(position, tolerance_m, near);
    std::optional<NearestPoint> best;
    std::uint32_t best_triangle = none;
    for (const std::uint32_t triangle : near) {
        if (normal && std::abs(dot(TriangleFrame(scene, triangle).normal, *normal)) < across_min) continue;
        const NearestPoint found = nearest_on_triangle(scene, triangle, position);
        if (found.distance > tolerance_m) continue;
        const bool nearer =
            !best || found.distance < best->distance || (found.distance == best->distance && triangle < best_triangle);
        if (!nearer) continue;
        best = found;
        best_triangle = triangle;
    }
    if (!best) return {};
    const auto on_side = [&](std::uint32_t side) {
        return point_on_triangle(scene, best_triangle, best->b1, best->b2, side);
    };
    if (!normal) return {on_side(0), on_side(1)};
    return {on_side(dot(TriangleFrame(scene, best_triangle).normal, *normal) > 0 ? 0 : 1)};
}

std::optional<std::uint32_t> continuing_side(const SurfacePoint& point, const TriangleFrame& frame, double distance_m) {
    const double facing = dot(frame.normal, point.normal);
    if (std::abs(facing) < cos_bend_max) return std::nullopt;
    const std::uint32_t side = facing > 0 ? 0 : 1;
    const double rise = std::abs(dot(point.position - frame.corner, frame.normal));
    // Neighbours in one plane may be wound either way; around a bend only the same side continues the surface.
    if (rise <= plane_tolerance_m(frame) && 1 - std::abs(facing) <= coplanar) return side;
    if (side != point.side || rise > rise_max * distance_m + plane_tolerance_m(frame)) return std::nullopt;
    return side;
}

}  // namespace lumenfarm
