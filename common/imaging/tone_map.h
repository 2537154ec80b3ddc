#pragma once

#include "common/imaging/picture.h"
#include "common/math/vec.h"

#include <cstdint>
#include <vector>

/// From luminances to a picture for screens.
namespace lumenfarm {

struct ToneMapping {
    double exposure = 1;   ///< 1 / (cd/m2)
    Vec3d white{1, 1, 1};  ///< linear sRGB of the light that shall look (nearly) white; Y > 0
};

/// Exposure by the pixels themselves: surfaces that are lit well, but do not shine, come out light. `white`: the colour
/// of the scene's light, to which an eye would have adapted.
ToneMapping automatic_tone(const Picture& picture, Vec3d white);

/// sRGB, 3 bytes a pixel: adaptation to white by 80 per cent (Bradford), exposure, a shoulder that keeps the order of
/// all luminances, colours out of gamut drawn towards grey of their luminance.
std::vector<std::uint8_t> tone_map(const Picture& picture, const ToneMapping& tone);

}  // namespace lumenfarm
