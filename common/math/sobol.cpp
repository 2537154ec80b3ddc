#include "common/math/sobol.h"

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

constexpr std::array<std::array<SobolPoint, 256>, 4> byte_tables() {
    std::array<std::array<SobolPoint, 256>, 4> tables{};
    for (std::uint32_t d = 0; d < sobol_dimensions; ++d) {
        const Directions directions = d == 0 ? van_der_corput() : directions_of(polynomials[d - 1]);
        for (std::uint32_t byte = 0; byte < 4; ++byte)
            for (std::uint32_t value = 0; value < 256; ++value)
                for (std::uint32_t bit = 0; bit < 8; ++bit)
                    if (value >> bit & 1u) tables[byte][value][d] ^= reverse_bits(directions[8 * byte + bit]);
    }
    return tables;
}

constexpr SobolBlock first_block() {
    const auto tables = byte_tables();
    SobolBlock block{};
    for (std::size_t d = 0; d < sobol_dimensions; ++d)
        for (std::size_t k = 0; k < sobol_block; ++k) block[d][k] = tables[0][k][d];
    return block;
}

}  // namespace

const std::array<std::array<SobolPoint, 256>, 4> sobol_reversed_tables = byte_tables();

const SobolBlock sobol_reversed_block = first_block();

}  // namespace lumenfarm
