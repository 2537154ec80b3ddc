#include "common/math/philox.h"
#include "common/math/sobol.h"

#include <gtest/gtest.h>

#include <bitset>
#include <set>

namespace lumenfarm {
namespace {

TEST(Philox, GivesTheKnownAnswersOfRandom123) {
    const std::array<std::uint32_t, 4> zero{0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u};
    EXPECT_EQ(philox(0, {0, 0, 0, 0}), zero);
    const std::array<std::uint32_t, 4> ones{0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu};
    EXPECT_EQ(philox(~0ull, {~0u, ~0u, ~0u, ~0u}), ones);
}

TEST(Philox, LanesDrawWhatSingleCountersDraw) {
    PhiloxLanes<8> lanes;
    PhiloxLanes<8>::Words c0, c2;
    for (std::uint32_t k = 0; k < 8; ++k) {
        c0[k] = 0x9e3779b9u * (k + 1);
        c2[k] = 0xbb67ae85u * (k + 1);
    }
    const std::uint64_t key = 0x0123456789abcdefull;
    lanes.draw(key, c0, 0xcafe1234u, c2, 0x87654321u);
    for (std::uint32_t k = 0; k < 8; ++k) {
        const auto single = philox(key, {c0[k], 0xcafe1234u, c2[k], 0x87654321u});
        for (std::uint32_t word = 0; word < 4; ++word) EXPECT_EQ(lanes.word(word)[k], single[word]);
    }
}

TEST(Sobol, FirstDimensionIsVanDerCorput) {
    EXPECT_EQ(sobol(0)[0], 0u);
    EXPECT_EQ(sobol(1)[0], 0x80000000u);
    EXPECT_EQ(sobol(2)[0], 0x40000000u);
    EXPECT_EQ(sobol(3)[0], 0xc0000000u);
    EXPECT_EQ(sobol(3)[1], 0x40000000u);
}

constexpr SobolPoint seeds{0x12345678u, 77, 99, 0xdeadbeefu, 5, 0x87654321u};

std::uint32_t scrambled(std::uint32_t index, std::size_t dimension, const SobolPoint& scramble = seeds) {
    return scrambled_sobol(index / sobol_block * sobol_block, scramble)[dimension][index % sobol_block];
}

TEST(Sobol, BlocksHoldThePointsOfTheirIndices) {
    for (const std::uint32_t first : {0u, 32u, 0x12345660u, 0xffffffe0u}) {
        const SobolBlock block = scrambled_sobol(first, seeds);
        for (std::uint32_t k = 0; k < sobol_block; ++k) {
            const SobolPoint point = sobol(first + k);
            for (std::size_t d = 0; d < sobol_dimensions; ++d)
                EXPECT_EQ(block[d][k], reverse_bits(scrambled_reversed(reverse_bits(point[d]), seeds[d])));
        }
    }
}

TEST(Sobol, EveryDimensionIsStratifiedBeforeAndAfterTheScramble) {
    constexpr std::uint32_t count = 1024;
    for (std::uint32_t d = 0; d < sobol_dimensions; ++d) {
        std::bitset<count> plain;
        std::bitset<count> shuffled;
        for (std::uint32_t i = 0; i < count; ++i) {
            plain.set(sobol(i)[d] >> 22);
            shuffled.set(scrambled(i, d) >> 22);
        }
        EXPECT_TRUE(plain.all()) << d;
        EXPECT_TRUE(shuffled.all()) << d;
    }
}

TEST(Sobol, FirstTwoDimensionsFillEveryElementaryBox) {
    // a (0, 10, 2)-net: every box of 2^-k by 2^-(10-k) holds exactly one of 1024 points
    for (std::uint32_t k = 0; k <= 10; ++k) {
        std::set<std::uint32_t> boxes;
        for (std::uint32_t i = 0; i < 1024; ++i) {
            const std::uint32_t x = k == 0 ? 0 : scrambled(i, 0) >> (32 - k);
            const std::uint32_t y = k == 10 ? 0 : scrambled(i, 1) >> (22 + k);
            boxes.insert(x << (10 - k) | y);
        }
        EXPECT_EQ(boxes.size(), 1024u) << k;
    }
}

TEST(Sobol, OtherSeedsGiveOtherPoints) {
    std::uint32_t same = 0;
    for (std::uint32_t i = 0; i < 1000; ++i) same += scrambled(i, 2) == scrambled(i, 2, SobolPoint{});
    EXPECT_LT(same, 3u);
}

}  // namespace
}  // namespace lumenfarm
