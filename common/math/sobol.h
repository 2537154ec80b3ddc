#pragma once

#include <cstdint>

/// Owen-scrambled Sobol points: any point by its index, no state.
namespace lumenfarm {

inline constexpr std::uint32_t sobol_dimensions = 6;

/// Coordinate of point `index` as a fraction of 2^32. Direction numbers: new-joe-kuo-6 [Joe and Kuo 2008].
/// REQUIRES: dimension < sobol_dimensions.
std::uint32_t sobol(std::uint32_t index, std::uint32_t dimension);

/// Nested uniform scramble of a coordinate by hashing [Laine and Karras 2011, constants of Vegdahl 2021].
std::uint32_t owen_scramble(std::uint32_t coordinate, std::uint32_t seed);

}  // namespace lumenfarm
