#pragma once

#include "common/math/vec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

/// The triangles that Embree holds: larger than the true ones, and with corners in an order that suits its arithmetic.
namespace lumenfarm {

using Corners = std::array<Vec3d, 3>;

/// The corner opposite the longest edge. Embree computes a triangle's normal in float from the two edges at its first
/// corner: where these are the shorter ones, thin triangles lose nothing.
inline std::size_t blunt_corner(const Corners& p) {
    const double a = length(p[2] - p[1]);
    const double b = length(p[0] - p[2]);
    const double c = length(p[1] - p[0]);
    return a >= b && a >= c ? 0 : b >= c ? 1 : 2;
}

struct EnlargedTriangle {
    Corners corners;  ///< contain all points of the plane within the enlargement of the true triangle
    bool sliver =
        false;  ///< too thin to be scaled: a right triangle around it, whose weights say nothing of the true one
};

/// The true triangle scaled about its incentre so that each edge moves outwards by `delta`; corners in the same order.
inline EnlargedTriangle enlarged(const Corners& p, double delta) {
    constexpr double scale_max = 4;       // beyond it corners run far away
    constexpr double sine_min = 1.0 / 8;  // of the blunt angle: nearer to 180 degrees Embree's normal is a poor one
    const std::size_t blunt = blunt_corner(p);
    const Vec3d from = p[(blunt + 1) % 3];
    const Vec3d to = p[(blunt + 2) % 3];
    const double longest = length(to - from);
    const double side_a = length(from - p[blunt]);
    const double side_b = length(to - p[blunt]);
    const double double_area = length(cross(p[1] - p[0], p[2] - p[0]));
    const double inradius = double_area / (longest + side_a + side_b);
    if (delta < (scale_max - 1) * inradius && double_area >= sine_min * side_a * side_b) {
        const Vec3d opposite = p[blunt] * longest + from * side_b + to * side_a;
        const Vec3d incentre = opposite * (1 / (longest + side_a + side_b));
        const double scale = (inradius + delta) / inradius;
        const auto moved = [&](Vec3d corner) { return incentre + (corner - incentre) * scale; };
        return {{moved(p[0]), moved(p[1]), moved(p[2])}, false};
    }
    // twice the rectangle along the longest edge, the right angle first
    const Vec3d along = (to - from) * (1 / longest);
    const Vec3d apex = p[blunt] - from;
    Vec3d across = apex - along * dot(apex, along);
    const double height = length(across);
    across = across * (1 / height);
    const Vec3d corner = from - along * delta - across * delta;
    return {{corner, corner + along * (2 * (longest + 2 * delta)), corner + across * (2 * (height + 2 * delta))}, true};
}

}  // namespace lumenfarm
