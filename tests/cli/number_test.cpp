#include "cli/number.h"

#include <gtest/gtest.h>

namespace lumenfarm {
namespace {

TEST(Number, CountsAreReadInEveryFormThatPeopleType) {
    const std::vector<std::pair<std::string, std::uint64_t>> table{
        {"0", 0},
        {"1", 1},
        {"5000", 5'000},
        {"25e6", 25'000'000},
        {"25M", 25'000'000},
        {"2.5e1", 25},
        {"1.5M", 1'500'000},
        {"3k", 3'000},
        {"4G", 4'000'000'000},
        {"1e0", 1},
        {"0.5k", 500},
        {"18446744073709551615", 18'446'744'073'709'551'615ull}};
    for (const auto& [text, number] : table) {
        const auto count = parse_count(text);
        ASSERT_TRUE(count) << text;
        EXPECT_EQ(*count, number) << text;
    }
}

TEST(Number, WhatIsNoCountIsRefusedWithItsText) {
    for (const std::string text : {"", "-1", "1.5", "abc", "25X", "25MM", "M", "1e400", "nan", "inf", "0x10", " 5",
                                   "5 ", "18446744073709551616", "1e-1", "1,000", "+5", "1e17"}) {
        const auto count = parse_count(text);
        ASSERT_FALSE(count) << text;
        EXPECT_EQ(count.error().code, ErrorCode::bad_input);
        EXPECT_NE(count.error().sentence.find("'" + text + "'"), std::string::npos) << count.error().sentence;
    }
}

TEST(Number, CountsStandBetweenCommas) {
    EXPECT_EQ(*parse_counts("1,2,4"), (std::vector<std::uint64_t>{1, 2, 4}));
    EXPECT_EQ(*parse_counts("25k"), std::vector<std::uint64_t>{25'000});
    for (const std::string text : {"", ",", "1,", ",1", "1,,2", "1;2", "1, 2", "1,x"}) {
        const auto counts = parse_counts(text);
        ASSERT_FALSE(counts) << text;
        EXPECT_NE(counts.error().sentence.find("'" + text + "'"), std::string::npos) << counts.error().sentence;
    }
}

TEST(Number, SignedNumbersStayWithin32Bits) {
    EXPECT_EQ(*parse_signed("-10"), -10);
    EXPECT_EQ(*parse_signed("1k"), 1'000);
    EXPECT_EQ(*parse_signed("2147483647"), 2'147'483'647);
    for (const std::string text : {"2147483648", "--1", "-", "1.5"}) EXPECT_FALSE(parse_signed(text)) << text;
}

TEST(Number, RealsAreFinite) {
    EXPECT_DOUBLE_EQ(*parse_real("0.05"), 0.05);
    EXPECT_DOUBLE_EQ(*parse_real("-1.5e-3"), -0.0015);
    EXPECT_DOUBLE_EQ(*parse_real("2k"), 2000);
    for (const std::string text : {"nan", "inf", "-inf", "1e999", "", "1m", "0.1.2"})
        EXPECT_FALSE(parse_real(text)) << text;
}

TEST(Number, VectorsHaveThreeParts) {
    const auto vector = parse_vector("1.5,0,-2e1");
    ASSERT_TRUE(vector);
    EXPECT_EQ(*vector, (Vec3d{1.5, 0, -20}));
    for (const std::string text : {"1,2", "1,2,3,4", "1,,3", "1,2,nan", "a,b,c", "", ",,", "1 2 3"})
        EXPECT_FALSE(parse_vector(text)) << text;
}

TEST(Number, RangesIncludeBothEnds) {
    const auto range = parse_range("7..1k");
    ASSERT_TRUE(range);
    EXPECT_EQ(range->first, 7u);
    EXPECT_EQ(range->last, 1'000u);
    EXPECT_EQ(parse_range("5..5")->last, 5u);
    EXPECT_EQ(parse_range("42")->first, 42u);
    EXPECT_EQ(parse_range("42")->last, 42u);
    for (const char* text : {"", "..", "1..", "..1", "1...3", "1-3", "a..b", "1..2..3", "-1..3", "1.5..2"})
        EXPECT_FALSE(parse_range(text)) << text;
    EXPECT_EQ(parse_range("3..2").error().sentence, "'3..2' ends before it begins");
}

TEST(Number, CountsAreShownWithThreeDigits) {
    EXPECT_EQ(short_count(0), "0");
    EXPECT_EQ(short_count(950), "950");
    EXPECT_EQ(short_count(12'345), "12.3k");
    EXPECT_EQ(short_count(1'214'000), "1.21M");
    EXPECT_EQ(short_count(20'000'000), "20M");
    EXPECT_EQ(short_count(4e9), "4G");
    EXPECT_EQ(short_count(999'999), "1M");
}

}  // namespace
}  // namespace lumenfarm
