#include "common/math/sobol.h"

#include <array>

namespace lumenfarm {
namespace {

struct Polynomial {
    std::uint32_t degree, coefficients;
    std::array<std::uint32_t, 4> initial;
};

// new-joe-kuo-6, dimensions 2 to 6; dimension 1 is the van der Corput sequence.
constexpr std::array<Polynomial, sobol_dimensions - 1> polynomials{{
    {1, 0, {1, 0, 0, 0}},
    {2, 1, {1, 3, 0, 0}},
    {3, 1, {1, 3, 1, 0}},
    {3, 2, {1, 1, 1, 0}},
    {4, 1, {1, 1, 3, 3}},
}};

using Directions = std::array<std::uint32_t, 32>;

constexpr Directions van_der_corput() {
    Directions v{};
    for (std::uint32_t k = 0; k < 32; ++k) v[k] = 1u << (31 - k);
    return v;
}

constexpr Directions directions_of(const Polynomial& p) {
    Directions v{};
    for (std::uint32_t k = 0; k < 32; ++k) {
        if (k < p.degree) {
            v[k] = p.initial[k] << (31 - k);
            continue;
        }
        v[k] = v[k - p.degree] ^ (v[k - p.degree] >> p.degree);
        for (std::uint32_t j = 1; j < p.degree; ++j)
            if (p.coefficients >> (p.degree - 1 - j) & 1u) v[k] ^= v[k - j];
    }
    return v;
}

/// The matrix product by bytes of the index: four look-ups instead of 32 conditional xors.
using ByteTables = std::array<std::array<std::uint32_t, 256>, 4>;

constexpr ByteTables byte_tables(const Directions& directions) {
    ByteTables tables{};
    for (std::uint32_t byte = 0; byte < 4; ++byte)
        for (std::uint32_t value = 0; value < 256; ++value)
            for (std::uint32_t bit = 0; bit < 8; ++bit)
                if (value >> bit & 1u) tables[byte][value] ^= directions[8 * byte + bit];
    return tables;
}

constexpr std::array<ByteTables, sobol_dimensions> all_tables() {
    std::array<ByteTables, sobol_dimensions> all{};
    all[0] = byte_tables(van_der_corput());
    for (std::uint32_t d = 1; d < sobol_dimensions; ++d) all[d] = byte_tables(directions_of(polynomials[d - 1]));
    return all;
}

constexpr std::array<ByteTables, sobol_dimensions> tables = all_tables();

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(x);
}

}  // namespace

std::uint32_t sobol(std::uint32_t index, std::uint32_t dimension) {
    const ByteTables& t = tables[dimension];
    return t[0][index & 255u] ^ t[1][index >> 8 & 255u] ^ t[2][index >> 16 & 255u] ^ t[3][index >> 24];
}

std::uint32_t owen_scramble(std::uint32_t coordinate, std::uint32_t seed) {
    std::uint32_t x = reverse_bits(coordinate);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse_bits(x);
}

}  // namespace lumenfarm
