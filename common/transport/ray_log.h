#pragma once

#include "common/transport/ray_query.h"

#include <cstdint>
#include <vector>

namespace lumenfarm {

/// A ray as it was traced, and how far its particle was.
struct LoggedRay : Ray {
    std::uint32_t wavelength = 0;  ///< bin
    std::uint32_t energy = 0;      ///< ticks that the particle carries along the ray
    std::int64_t absorbed = 0;     ///< ticks that the trace had booked before: of this particle, if it is traced alone
    std::int64_t cut_off = 0;      ///< the same
};

}  // namespace lumenfarm
