#pragma once

#include "common/transport/lanes.h"
#include "common/transport/triangle_test.h"

#include <cstddef>

namespace lumenfarm {

/// A triangle in each lane. The functions do what their namesakes in triangle_test.h do.
class TriangleLanes {
public:
    void set(std::size_t lane, const TriangleRecord& triangle) {
        for (std::size_t c = 0; c < 3; ++c) {
            x_[c][lane] = triangle.corners[c].x;
            y_[c][lane] = triangle.corners[c].y;
            z_[c][lane] = triangle.corners[c].z;
        }
    }
    Vec3d corner(std::size_t lane, std::size_t c) const {
        return {static_cast<double>(x_[c][lane]), static_cast<double>(y_[c][lane]), static_cast<double>(z_[c][lane])};
    }
    Vec3d unit_normal(std::size_t lane) const {
        const Vec3d a = corner(lane, 0);
        return normalize(cross(corner(lane, 1) - a, corner(lane, 2) - a));
    }
    EdgeVolumes edge_volumes(std::size_t lane, Vec3d origin, Vec3d direction) const {
        return lumenfarm::edge_volumes(corner(lane, 0) - origin, corner(lane, 1) - origin, corner(lane, 2) - origin,
                                       direction);
    }
    Vec3d point(std::size_t lane, double b1, double b2) const {
        return point_on(corner(lane, 0), corner(lane, 1), corner(lane, 2), b1, b2);
    }

private:
    alignas(64) std::array<Lanes<float>, 3> x_{}, y_{}, z_{};
};

}  // namespace lumenfarm
