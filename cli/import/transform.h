#pragma once

#include "common/math/vec.h"

#include <array>

namespace lumenfarm::import {

/// An affine map: p -> columns[0] p.x + columns[1] p.y + columns[2] p.z + columns[3].
struct Transform {
    std::array<Vec3d, 4> columns{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{0, 0, 0}};

    Vec3d vector(Vec3d v) const { return columns[0] * v.x + columns[1] * v.y + columns[2] * v.z; }
    Vec3d point(Vec3d p) const { return vector(p) + columns[3]; }
    /// True when it turns counter-clockwise into clockwise.
    bool mirrors() const { return dot(cross(columns[0], columns[1]), columns[2]) < 0; }
    /// `inner` first, then this.
    Transform after(const Transform& inner) const {
        return {
            {vector(inner.columns[0]), vector(inner.columns[1]), vector(inner.columns[2]), point(inner.columns[3])}};
    }
};

}  // namespace lumenfarm::import
