#include "common/solution/texel_layout.h"

#include "tests/solution/quad_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace lumenfarm {
namespace {

class TexelCells : public testing::TestWithParam<std::uint32_t> {};

TEST_P(TexelCells, CentroidOfACellLiesInThatCell) {
    const std::uint32_t n = GetParam();
    for (std::uint32_t cell = 0; cell < n * n; ++cell) {
        const Vec2f b = TexelLayout::cell_centroid(cell, n);
        EXPECT_GT(1 - b.x - b.y, 0);
        const auto b1 = static_cast<std::uint32_t>(b.x * 65'536), b2 = static_cast<std::uint32_t>(b.y * 65'536);
        ASSERT_EQ(TexelLayout::cell_of(b1, b2, n), cell) << "n " << n;
    }
}

TEST_P(TexelCells, EveryPackedPointFallsIntoSomeCell) {
    const std::uint32_t n = GetParam();
    for (std::uint32_t b1 = 0; b1 < 65'536; b1 += 97) {
        const std::uint32_t most = std::min(65'536 - b1, 65'535u);  // b1 + b2 <= 65536
        for (const std::uint32_t b2 : {0u, 1u, most / 2, most - (most > 0 ? 1 : 0), most})
            ASSERT_LT(TexelLayout::cell_of(b1, b2, n), n * n);
    }
    EXPECT_LT(TexelLayout::cell_of(65'535, 1, n), n * n);
}

INSTANTIATE_TEST_SUITE_P(Rows, TexelCells, testing::Values(1u, 2u, 3u, 7u, 64u, 200u));

TEST(TexelLayout, UniformPointsFillCellsEvenlyBesideTheDiagonals) {
    // every packed point of a triangle, n = 1024: cells are only 64 steps wide, so a skewed tie would show
    constexpr std::uint32_t n = 1'024;
    std::vector<std::uint32_t> counts(n * n);
    for (std::uint32_t b1 = 0; b1 < 256; ++b1)
        for (std::uint32_t b2 = 0; b2 < 4'096; ++b2) ++counts[TexelLayout::cell_of(b1, b2, n)];
    for (std::uint32_t cell = 0; cell < 128; ++cell) EXPECT_EQ(counts[cell], 2'048u) << cell;
}

TEST(TexelLayout, TexelsOfAllTrianglesAndSidesAreDistinct) {
    test::QuadScene quads;
    const auto grey = quads.lambert(0.5);
    quads.quad("small", {0, 0, 0}, {0.3f, 0, 0}, {0, 0.4f, 0}, grey);
    quads.quad("large", {0, 0, 1}, {3, 0, 0}, {0, 4, 0}, grey);
    const auto layout = TexelLayout::make(quads.scene, 0.51);
    ASSERT_TRUE(layout);
    EXPECT_EQ(layout->rows(0), 1u);   // 0.5 m diagonal
    EXPECT_EQ(layout->rows(2), 10u);  // 5 m diagonal
    EXPECT_EQ(layout->texel_count(), 2u * (1 + 1 + 100 + 100));
    for (std::uint64_t texel = 0; texel < layout->texel_count(); ++texel) {
        const auto place = layout->place_of(texel);
        EXPECT_EQ(layout->first_texel(place.triangle, place.side) + place.cell, texel);
    }
}

TEST(TexelLayout, TooManyTexelsAreRefusedWithASizeThatFits) {
    test::QuadScene quads;
    const auto grey = quads.lambert(0.5);
    for (int i = 0; i < 200; ++i) quads.quad("q" + std::to_string(i), {0, 0, float(i)}, {1, 0, 0}, {0, 1, 0}, grey);
    const auto refused = TexelLayout::make(quads.scene, 1e-6);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
    const std::string& sentence = refused.error().sentence;
    const auto at = sentence.find("400000000, ");
    ASSERT_NE(at, std::string::npos) << sentence;
    EXPECT_TRUE(TexelLayout::make(quads.scene, std::stod(sentence.substr(at + 11)))) << sentence;
    for (const double absurd :
         {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
        EXPECT_FALSE(TexelLayout::make(quads.scene, absurd));
}

}  // namespace
}  // namespace lumenfarm
