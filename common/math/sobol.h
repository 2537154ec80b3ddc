#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Owen-scrambled Sobol points: any point by its index, no state.
namespace lumenfarm {

inline constexpr std::uint32_t sobol_dimensions = 6;
inline constexpr std::uint32_t sobol_block = 32;

using SobolPoint = std::array<std::uint32_t, sobol_dimensions>;  ///< fractions of 2^32
/// Points of sobol_block consecutive indices side by side, by dimension.
using SobolBlock = std::array<std::array<std::uint32_t, sobol_block>, sobol_dimensions>;

/// What each value of each byte of the index adds (xor) to a point, with all bits in reverse order: 24 KiB.
extern const std::array<std::array<SobolPoint, 256>, 4> sobol_reversed_tables;
/// The points 0 to sobol_block - 1, with all bits in reverse order.
extern const SobolBlock sobol_reversed_block;

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(x);
}

inline SobolPoint reversed_sobol(std::uint32_t index) {
    SobolPoint x;
    for (std::size_t d = 0; d < sobol_dimensions; ++d)
        x[d] = sobol_reversed_tables[0][index & 255u][d] ^ sobol_reversed_tables[1][index >> 8 & 255u][d] ^
               sobol_reversed_tables[2][index >> 16 & 255u][d] ^ sobol_reversed_tables[3][index >> 24][d];
    return x;
}

/// Point `index`. Direction numbers: new-joe-kuo-6 [Joe and Kuo 2008].
inline SobolPoint sobol(std::uint32_t index) {
    SobolPoint x = reversed_sobol(index);
    for (std::uint32_t& coordinate : x) coordinate = reverse_bits(coordinate);
    return x;
}

/// A nested uniform scramble of a coordinate in reverse order, by hashing [Laine and Karras 2011, constants of Vegdahl
/// 2021].
inline std::uint32_t scrambled_reversed(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/// The scrambled points `first` to `first` + sobol_block - 1, a seed for each dimension. REQUIRES: `first` is a
/// multiple of sobol_block.
inline SobolBlock scrambled_sobol(std::uint32_t first, const SobolPoint& seeds) {
    const SobolPoint base = reversed_sobol(first);
    SobolBlock points;
    for (std::size_t d = 0; d < sobol_dimensions; ++d)
        for (std::size_t k = 0; k < sobol_block; ++k)
            points[d][k] = reverse_bits(scrambled_reversed(base[d] ^ sobol_reversed_block[d][k], seeds[d]));
    return points;
}

}  // namespace lumenfarm
