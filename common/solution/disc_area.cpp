#include "common/solution/disc_area.h"

#include "common/solution/surface_point.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lumenfarm {
namespace {

struct Point {
    double x, y;
};

double cross2(Point a, Point b) { return a.x * b.y - a.y * b.x; }
double dot2(Point a, Point b) { return a.x * b.x + a.y * b.y; }
Point mix(Point a, Point b, double t) { return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}; }

/// Signed area between the origin and the part from a to b of an edge, cut with the circle about the origin.
double sector(Point a, Point b, double radius) { return radius * radius * std::atan2(cross2(a, b), dot2(a, b)) / 2; }

double edge_area(Point a, Point b, double radius) {
    const Point d{b.x - a.x, b.y - a.y};
    const double dd = dot2(d, d);
    if (dd == 0) return 0;
    const double half = dot2(a, d) / dd;
    const double under_root = half * half - (dot2(a, a) - radius * radius) / dd;
    if (under_root <= 0) return sector(a, b, radius);
    // the edge is inside the circle for t in [enter, leave]
    const double root = std::sqrt(under_root);
    const double enter = std::clamp(-half - root, 0.0, 1.0), leave = std::clamp(-half + root, 0.0, 1.0);
    if (enter >= leave) return sector(a, b, radius);
    const Point first = mix(a, b, enter), last = mix(a, b, leave);
    double area = cross2(first, last) / 2;
    if (enter > 0) area += sector(a, first, radius);
    if (leave < 1) area += sector(last, b, radius);
    return area;
}

}  // namespace

double area_within_m2(const Scene& scene, std::uint32_t triangle, Vec3d centre, double radius_m) {
    const TriangleFrame frame(scene, triangle);
    const Vec3d from_centre = frame.corner - centre;
    const double height = dot(from_centre, frame.normal);
    const double cut = radius_m * radius_m - height * height;
    if (cut <= 0) return 0;
    const double radius = std::sqrt(cut);
    const Vec3d u = normalize(frame.edge1), v = cross(frame.normal, u);
    const auto flat = [&](Vec3d p) { return Point{dot(p, u), dot(p, v)}; };
    const std::array<Point, 3> corners{flat(from_centre), flat(from_centre + frame.edge1),
                                       flat(from_centre + frame.edge2)};
    double area = 0;
    for (std::size_t i = 0; i < 3; ++i) area += edge_area(corners[i], corners[(i + 1) % 3], radius);
    return std::max(area, 0.0);
}

}  // namespace lumenfarm
