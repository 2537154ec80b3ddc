#pragma once

#include "common/math/vec.h"

#include <cstddef>
#include <cstdint>
#include <vector>

/// A rendered view, row by row from the top left.
namespace lumenfarm {

struct Pixel {
    /// Linear sRGB primaries, D65 white; 0.2126 R + 0.7152 G + 0.0722 B is the luminance [cd/m2].
    Vec3f radiance;
    float illuminance_lx = 0;  ///< on the first diffuse surfaces that the pixel shows
    float relative_error = 1;  ///< standard error over illuminance; 1 where nothing is known
    float hit_count = 0;       ///< hits in the neighbourhood of the estimate
};

struct Picture {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<Pixel> pixels;

    const Pixel& at(std::uint32_t column, std::uint32_t row) const { return pixels[std::size_t{row} * width + column]; }
};

}  // namespace lumenfarm
