#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "common/support/limits.h"

#include <cstdint>

namespace lumenfarm {

/// Nothing of any scene is so far from where a particle left a surface or its light [m].
inline constexpr double farthest_m = 8 * limits::coordinate_max_m;

/// A particle of a light on its way between two surfaces: all that the rest of its path depends on.
struct Flight {
    Vec3d origin;                        ///< [m], where it left a surface or its light; never rounded again
    Vec3d direction;                     ///< unit
    double travelled_m = 0;              ///< from the origin on; nothing was met so far
    std::uint32_t from_triangle = none;  ///< of the whole scene; not met again
    std::uint32_t particle = 0;          ///< index
    std::uint32_t bounce = 0;
    std::uint32_t wavelength = 0;    ///< bin
    std::uint32_t energy = 0;        ///< ticks now
    std::uint32_t start_energy = 0;  ///< ticks at the light
    bool operator==(const Flight&) const = default;
};

}  // namespace lumenfarm
