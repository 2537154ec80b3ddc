#pragma once

#include "common/math/vec.h"
#include "common/support/limits.h"

#include <cmath>
#include <cstdint>

/// What is kept of a particle's meeting with a surface; everything that the solution adds up is a function of it.
namespace lumenfarm {

/// 16 bytes, as on the wire (little-endian, docs/wire.md). b1, b2: barycentric weights of the triangle's second and
/// third corner, floor(b * 65536). Direction: of travel, octahedral. Wavelength: a bin (spectrum.h).
struct HitRecord {
    std::uint32_t triangle = 0;
    std::uint16_t b1 = 0, b2 = 0;
    std::uint16_t direction_u = 0, direction_v = 0;
    std::uint16_t wavelength = 0;
    std::uint16_t flags = 0;  ///< bits 0..9 bounce (saturating), 10..14 batch, 15 side (1 is the back)

    std::uint32_t bounce() const { return flags & 1023u; }
    std::uint32_t batch() const { return (flags >> 10) & 31u; }
    std::uint32_t side() const { return flags >> 15; }
    bool operator==(const HitRecord&) const = default;
};
static_assert(sizeof(HitRecord) == limits::hit_record_bytes);
static_assert(limits::batches == 32);

inline std::uint16_t hit_flags(std::uint32_t bounce, std::uint32_t batch, std::uint32_t side) {
    return static_cast<std::uint16_t>((bounce < 1023 ? bounce : 1023) | batch << 10 | side << 15);
}

/// The batch of a particle: blocks of 64 consecutive indices in turn, so that every batch is spread over the light.
inline std::uint32_t batch_of(std::uint64_t particle) { return static_cast<std::uint32_t>(particle >> 6 & 31u); }

/// Octahedral map of a unit vector to 2 x 16 bits and back (within 7e-5 rad) [Cigolle et al. 2014].
struct OctahedralDirection {
    std::uint16_t u = 0, v = 0;
};
inline OctahedralDirection encode_direction(Vec3f unit) {
    const float scale = 1 / (std::abs(unit.x) + std::abs(unit.y) + std::abs(unit.z));
    const float u = unit.x * scale;
    const float v = unit.y * scale;
    // the lower half is folded outwards; values are selected, since which half is a coin toss
    const float folded_u = std::copysign(1 - std::abs(v), u);
    const float folded_v = std::copysign(1 - std::abs(u), v);
    const bool lower = unit.z < 0;
    const auto quantize = [](float value) {
        return static_cast<std::uint16_t>(static_cast<std::int32_t>((value + 1) * 32767.5f + 0.5f));
    };
    return {quantize(lower ? folded_u : u), quantize(lower ? folded_v : v)};
}
Vec3d decode_direction(OctahedralDirection packed);

}  // namespace lumenfarm
