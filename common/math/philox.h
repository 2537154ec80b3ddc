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
        static_assert(lanes % 4 == 0);
        std::array<RoundKey, rounds> keys;
        auto key0 = static_cast<std::uint32_t>(seed);
        auto key1 = static_cast<std::uint32_t>(seed >> 32);
        for (RoundKey& key : keys) {
            key = {_mm_set1_epi64x(key0), _mm_set1_epi64x(key1)};
            key0 += 0x9e3779b9u;  // the golden ratio and sqrt(3) - 1, the Weyl steps of Philox
            key1 += 0xbb67ae85u;
        }
        for (std::size_t k = 0; k < lanes; k += 4) {
            // two registers in turn: one's multiplications run while the other waits for its own
            Block a = load(k), b = load(k + 2);
            for (const RoundKey& key : keys) {
                a = turned(a, key);
                b = turned(b, key);
            }
            store(k, a);
            store(k + 2, b);
        }
    }

private:
    static constexpr std::size_t rounds = 10;
    struct RoundKey {
        __m128i low, high;
    };
    struct Block {
        __m128i w0, w1, w2, w3;
    };

    static Block turned(const Block& in, const RoundKey& key) {
        // only the low half of each 64-bit lane counts; what gathers above is dropped by the multiplication
        const __m128i product0 = _mm_mul_epu32(in.w0, _mm_set1_epi64x(0xd2511f53u));
        const __m128i product1 = _mm_mul_epu32(in.w2, _mm_set1_epi64x(0xcd9e8d57u));
        const auto high = [](__m128i product) { return _mm_shuffle_epi32(product, _MM_SHUFFLE(3, 3, 1, 1)); };
        return {_mm_xor_si128(high(product1), _mm_xor_si128(in.w1, key.low)), product1,
                _mm_xor_si128(high(product0), _mm_xor_si128(in.w3, key.high)), product0};
    }
    Block load(std::size_t lane) const {
        const auto word = [&](std::size_t w) {
            return _mm_load_si128(reinterpret_cast<const __m128i*>(&words_[w][lane]));
        };
        return {word(0), word(1), word(2), word(3)};
    }
    void store(std::size_t lane, const Block& block) {
        const auto word = [&](std::size_t w, __m128i value) {
            _mm_store_si128(reinterpret_cast<__m128i*>(&words_[w][lane]), value);
        };
        word(0, block.w0);
        word(1, block.w1);
        word(2, block.w2);
        word(3, block.w3);
    }

    alignas(64) std::array<std::array<std::uint64_t, lanes>, 4> words_{};  ///< in the low halves
};

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
