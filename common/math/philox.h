#pragma once

#include <Random123/philox.h>

#include <array>
#include <cstddef>
#include <cstdint>

/// Counter-based randomness (law 2): no state, the same value for the same key and counter, wherever it is asked.
namespace lumenfarm {

/// Philox4x32-10 [Salmon et al. 2011, Random123].
inline std::array<std::uint32_t, 4> philox(std::uint64_t key, std::array<std::uint32_t, 4> counter) {
    const r123::Philox4x32 generator;
    const r123::Philox4x32::ctr_type c{{counter[0], counter[1], counter[2], counter[3]}};
    const r123::Philox4x32::key_type k{{static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(key >> 32)}};
    const r123::Philox4x32::ctr_type r = generator(c, k);
    return {r[0], r[1], r[2], r[3]};
}

/// Philox4x32-10 for `lanes` counters side by side, word by word, so that the rounds fill vector registers. In:
/// counters; out: draws, the same values as philox().
template <std::size_t lanes>
struct PhiloxLanes {
    alignas(64) std::array<std::array<std::uint32_t, lanes>, 4> words;

    void draw(std::uint64_t seed) {
        auto key0 = static_cast<std::uint32_t>(seed);
        auto key1 = static_cast<std::uint32_t>(seed >> 32);
        for (int round = 0; round < 10; ++round) {
            for (std::size_t k = 0; k < lanes; ++k) {
                const std::uint64_t product0 = std::uint64_t{words[0][k]} * 0xd2511f53u;
                const std::uint64_t product1 = std::uint64_t{words[2][k]} * 0xcd9e8d57u;
                words[0][k] = static_cast<std::uint32_t>(product1 >> 32) ^ words[1][k] ^ key0;
                words[2][k] = static_cast<std::uint32_t>(product0 >> 32) ^ words[3][k] ^ key1;
                words[1][k] = static_cast<std::uint32_t>(product1);
                words[3][k] = static_cast<std::uint32_t>(product0);
            }
            key0 += 0x9e3779b9u;  // the golden ratio and sqrt(3) - 1, the Weyl steps of Philox
            key1 += 0xbb67ae85u;
        }
    }
};

/// Uniform in the open interval (0, 1): the centre of one of 2^32 cells.
constexpr double uniform(std::uint32_t bits) { return (bits + 0.5) * 0x1p-32; }

}  // namespace lumenfarm
