#pragma once

#include "common/math/vec.h"

#include <array>
#include <cstddef>

/// Many particles side by side, one lane each: the same operations on whole arrays, which the compiler turns into
/// vector instructions, and one lane's memory is fetched while another computes. What a lane holds never depends on
/// its neighbours.
namespace lumenfarm {

inline constexpr std::size_t lane_count = 32;

template <class T>
using Lanes = std::array<T, lane_count>;

struct alignas(64) VecLanes {
    Lanes<double> x{}, y{}, z{};

    Vec3d at(std::size_t lane) const { return {x[lane], y[lane], z[lane]}; }
    void set(std::size_t lane, Vec3d v) {
        x[lane] = v.x;
        y[lane] = v.y;
        z[lane] = v.z;
    }
};

}  // namespace lumenfarm
