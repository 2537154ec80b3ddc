#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Owen-scrambled Sobol points: any point by its index, no state. All dimensions of a point are made side by side, so
/// that they fill a vector register.
namespace lumenfarm {

inline constexpr std::uint32_t sobol_dimensions = 6;
inline constexpr std::uint32_t sobol_lanes = 8;  ///< the two above sobol_dimensions are zero

using SobolPoint = std::array<std::uint32_t, sobol_lanes>;  ///< fractions of 2^32

/// What each value of each byte of the index adds (xor) to a point, with all bits in reverse order: 32 KiB.
extern const std::array<std::array<SobolPoint, 256>, 4> sobol_reversed_tables;

inline std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(x);
}

/// Point `index`. Direction numbers: new-joe-kuo-6 [Joe and Kuo 2008].
inline SobolPoint sobol(std::uint32_t index) {
    SobolPoint x;
    for (std::size_t d = 0; d < sobol_lanes; ++d)
        x[d] = reverse_bits(sobol_reversed_tables[0][index & 255u][d] ^ sobol_reversed_tables[1][index >> 8 & 255u][d] ^
                            sobol_reversed_tables[2][index >> 16 & 255u][d] ^ sobol_reversed_tables[3][index >> 24][d]);
    return x;
}

/// The same with a nested uniform scramble by hashing, a seed for each dimension [Laine and Karras 2011, constants of
/// Vegdahl 2021].
inline SobolPoint scrambled_sobol(std::uint32_t index, const SobolPoint& seeds) {
    SobolPoint point;
    for (std::size_t d = 0; d < sobol_lanes; ++d) {
        std::uint32_t x = sobol_reversed_tables[0][index & 255u][d] ^ sobol_reversed_tables[1][index >> 8 & 255u][d] ^
                          sobol_reversed_tables[2][index >> 16 & 255u][d] ^ sobol_reversed_tables[3][index >> 24][d];
        x ^= x * 0x3d20adeau;
        x += seeds[d];
        x *= (seeds[d] >> 16) | 1u;
        x ^= x * 0x05526c56u;
        x ^= x * 0x53a22864u;
        point[d] = reverse_bits(x);
    }
    return point;
}

}  // namespace lumenfarm
