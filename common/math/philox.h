#pragma once

#include <Random123/philox.h>
#include <emmintrin.h>

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

/// Philox4x32-10 for `lanes` counters side by side, two to a register. In: counters; out: draws, the same values as
/// philox().
template <std::size_t lanes>
class PhiloxLanes {
public:
    void set(std::size_t lane, std::array<std::uint32_t, 4> counter) {
        for (std::size_t w = 0; w < 4; ++w) words_[w][lane] = counter[w];
    }
    std::uint32_t word(std::size_t w, std::size_t lane) const { return static_cast<std::uint32_t>(words_[w][lane]); }

    void draw(std::uint64_t seed) {
        static_assert(lanes % 2 == 0);
        const __m128i multiplier0 = _mm_set1_epi64x(0xd2511f53u);
        const __m128i multiplier1 = _mm_set1_epi64x(0xcd9e8d57u);
        for (std::size_t k = 0; k < lanes; k += 2) {
            __m128i w0 = load(0, k), w1 = load(1, k), w2 = load(2, k), w3 = load(3, k);
            auto key0 = static_cast<std::uint32_t>(seed);
            auto key1 = static_cast<std::uint32_t>(seed >> 32);
            for (int round = 0; round < 10; ++round) {
                // only the low half of each 64-bit lane counts; what gathers above is dropped by the multiplication
                const __m128i product0 = _mm_mul_epu32(w0, multiplier0);
                const __m128i product1 = _mm_mul_epu32(w2, multiplier1);
                w0 = _mm_xor_si128(_mm_xor_si128(_mm_srli_epi64(product1, 32), w1), _mm_set1_epi64x(key0));
                w2 = _mm_xor_si128(_mm_xor_si128(_mm_srli_epi64(product0, 32), w3), _mm_set1_epi64x(key1));
                w1 = product1;
                w3 = product0;
                key0 += 0x9e3779b9u;  // the golden ratio and sqrt(3) - 1, the Weyl steps of Philox
                key1 += 0xbb67ae85u;
            }
            store(0, k, w0);
            store(1, k, w1);
            store(2, k, w2);
            store(3, k, w3);
        }
    }

private:
    __m128i load(std::size_t w, std::size_t lane) const {
        return _mm_load_si128(reinterpret_cast<const __m128i*>(&words_[w][lane]));
    }
    void store(std::size_t w, std::size_t lane, __m128i value) {
        _mm_store_si128(reinterpret_cast<__m128i*>(&words_[w][lane]), value);
    }

    alignas(64) std::array<std::array<std::uint64_t, lanes>, 4> words_{};  ///< in the low halves
};

/// Uniform in the open interval (0, 1): the centre of one of 2^32 cells.
constexpr double uniform(std::uint32_t bits) { return (bits + 0.5) * 0x1p-32; }

}  // namespace lumenfarm
