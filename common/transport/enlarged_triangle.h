#pragma once

#include "common/math/vec.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lumenfarm {

/// A triangle that contains all points of the plane within `delta` of the true one.
struct EnlargedTriangle {
    std::array<Vec3d, 3> corners;
    /// Scaled about the incentre by this, so that each edge moved outwards by delta; 0 for slivers, which become half
    /// of a parallelogram instead.
    double scale = 0;
};

inline EnlargedTriangle enlarged(const std::array<Vec3d, 3>& p, double delta) {
    constexpr double scale_max = 4;  // beyond it corners run far away
    const double a = length(p[2] - p[1]);
    const double b = length(p[0] - p[2]);
    const double c = length(p[1] - p[0]);
    const double around = a + b + c;
    const double inradius = length(cross(p[1] - p[0], p[2] - p[0])) / around;
    if (delta < (scale_max - 1) * inradius) {
        const Vec3d incentre = (p[0] * a + p[1] * b + p[2] * c) * (1 / around);
        const double scale = (inradius + delta) / inradius;
        return {{incentre + (p[0] - incentre) * scale, incentre + (p[1] - incentre) * scale,
                 incentre + (p[2] - incentre) * scale},
                scale};
    }
    // a sliver: twice the rectangle along its longest edge
    const std::size_t longest = a >= b && a >= c ? 0 : b >= c ? 1 : 2;
    const Vec3d from = p[(longest + 1) % 3];
    const Vec3d along = normalize(p[(longest + 2) % 3] - from);
    const Vec3d apex = p[longest] - from;
    Vec3d across = apex - along * dot(apex, along);
    const double height = length(across);
    across = across * (1 / height);
    const Vec3d corner = from - along * delta - across * delta;
    return {{corner, corner + along * (2 * (std::max({a, b, c}) + 2 * delta)),
             corner + across * (2 * (height + 2 * delta))},
            0};
}

}  // namespace lumenfarm
