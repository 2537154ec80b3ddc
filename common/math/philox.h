#pragma once

#include <Random123/philox.h>
#include <smmintrin.h>

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

/// Philox4x32-10 for `lanes` counters side by side: the same draws as philox().
template <std::size_t lanes>
class PhiloxLanes {
public:
    using Words = std::array<std::uint32_t, lanes>;

    /// Counters {c0[lane], c1, c2[lane], c3}.
    void draw(std::uint64_t key, const Words& c0, std::uint32_t c1, const Words& c2, std::uint32_t c3);
    /// What was drawn, by word.
    const Words& word(std::size_t w) const { return words_[w]; }

private:
    static constexpr std::size_t rounds = 10;
    struct RoundKey {
        __m128i low, high;
    };
    /// Two counters. Only the low half of each 64-bit lane counts; the multiplications drop what gathers above.
    struct Block {
        __m128i w0, w1, w2, w3;
    };

    static Block turned(const Block& in, const RoundKey& key) {
        const __m128i product0 = _mm_mul_epu32(in.w0, _mm_set1_epi64x(0xd2511f53u));
        const __m128i product1 = _mm_mul_epu32(in.w2, _mm_set1_epi64x(0xcd9e8d57u));
        const auto high = [](__m128i product) { return _mm_shuffle_epi32(product, _MM_SHUFFLE(3, 3, 1, 1)); };
        return {_mm_xor_si128(high(product1), _mm_xor_si128(in.w1, key.low)), product1,
                _mm_xor_si128(high(product0), _mm_xor_si128(in.w3, key.high)), product0};
    }

    std::array<Words, 4> words_{};
};

template <std::size_t lanes>
inline void PhiloxLanes<lanes>::draw(std::uint64_t key, const Words& c0, std::uint32_t c1, const Words& c2,
                                     std::uint32_t c3) {
    static_assert(lanes % 4 == 0);
    std::array<RoundKey, rounds> keys;
    auto low = static_cast<std::uint32_t>(key);
    auto high = static_cast<std::uint32_t>(key >> 32);
    for (RoundKey& round : keys) {
        round = {_mm_set1_epi64x(low), _mm_set1_epi64x(high)};
        low += 0x9e3779b9u;  // the golden ratio and sqrt(3) - 1, the Weyl steps of Philox
        high += 0xbb67ae85u;
    }
    for (std::size_t k = 0; k < lanes; k += 4) {
        const auto two = [](const Words& words, std::size_t lane) {
            return _mm_cvtepu32_epi64(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(&words[lane])));
        };
        // two blocks in turn: one's multiplications run while the other waits for its own
        Block a{two(c0, k), _mm_set1_epi64x(c1), two(c2, k), _mm_set1_epi64x(c3)};
        Block b{two(c0, k + 2), a.w1, two(c2, k + 2), a.w3};
        for (const RoundKey& round : keys) {
            a = turned(a, round);
            b = turned(b, round);
        }
        const auto keep = [&](Words& words, __m128i first, __m128i second) {
            const __m128 low_halves =
                _mm_shuffle_ps(_mm_castsi128_ps(first), _mm_castsi128_ps(second), _MM_SHUFFLE(2, 0, 2, 0));
            _mm_storeu_si128(reinterpret_cast<__m128i*>(&words[k]), _mm_castps_si128(low_halves));
        };
        keep(words_[0], a.w0, b.w0);
        keep(words_[1], a.w1, b.w1);
        keep(words_[2], a.w2, b.w2);
        keep(words_[3], a.w3, b.w3);
    }
}

/// Uniform in the open interval (0, 1): the centre of one of 2^32 cells.
constexpr double uniform(std::uint32_t bits) {
    // as bits + 0.5, through the conversion of signed integers, which vector registers have
    return (static_cast<std::int32_t>(bits ^ 0x80000000u) + (0x1p31 + 0.5)) * 0x1p-32;
}
/// The centre of one of 2^23 cells, from the highest bits.
constexpr float uniform_float(std::uint32_t bits) {
    return (static_cast<float>(static_cast<std::int32_t>(bits >> 9)) + 0.5f) * 0x1p-23f;
}

}  // namespace lumenfarm
