#pragma once

#include <array>
#include <cstdint>

/// Owen-scrambled Sobol points: any point by its index, no state.
namespace lumenfarm {

inline constexpr std::uint32_t sobol_dimensions = 6;

/// Bits of the coordinates that each byte of the index adds (xor), lowest bit first: 24 KiB, four look-ups a coordinate.
extern const std::array<std::array<std::array<std::uint32_t, 256>, 4>, sobol_dimensions> sobol_reversed_tables;

inline std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(x);
}

inline std::uint32_t sobol_reversed(std::uint32_t index, std::uint32_t dimension) {
    const auto& t = sobol_reversed_tables[dimension];
    return t[0][index & 255u] ^ t[1][index >> 8 & 255u] ^ t[2][index >> 16 & 255u] ^ t[3][index >> 24];
}

/// Coordinate of point `index` as a fraction of 2^32. Direction numbers: new-joe-kuo-6 [Joe and Kuo 2008].
/// REQUIRES: dimension < sobol_dimensions.
inline std::uint32_t sobol(std::uint32_t index, std::uint32_t dimension) {
    return reverse_bits(sobol_reversed(index, dimension));
}

/// The same with a nested uniform scramble by hashing [Laine and Karras 2011, constants of Vegdahl 2021].
inline std::uint32_t scrambled_sobol(std::uint32_t index, std::uint32_t dimension, std::uint32_t seed) {
    std::uint32_t x = sobol_reversed(index, dimension);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse_bits(x);
}

}  // namespace lumenfarm
