#include "common/imaging/picture_file.h"

#include "common/imaging/tone_map.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

namespace lumenfarm {
namespace {

class PictureFile : public testing::Test {
protected:
    PictureFile() : folder_(std::filesystem::path(testing::TempDir()) / ("lumenfarm_pictures_" + name())) {
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    ~PictureFile() override { std::filesystem::remove_all(folder_); }
    static std::string name() { return testing::UnitTest::GetInstance()->current_test_info()->name(); }
    std::size_t files() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
    }
    std::filesystem::path folder_;
};

Picture sample() {
    Picture picture{3, 2, std::vector<Pixel>(6)};
    for (std::size_t i = 0; i < 6; ++i) {
        const auto v = static_cast<float>(i);
        picture.pixels[i] = {{v, 1e6f * v, -0.25f}, 100 + v, 0.01f * v, 5 * v};
    }
    return picture;
}

TEST_F(PictureFile, ExrHoldsItsLayersByName) {
    ASSERT_TRUE(write_exr(folder_ / "view.exr", sample()));
    EXPECT_EQ(files(), 1u);
    const auto input = OIIO::ImageInput::open((folder_ / "view.exr").string());
    ASSERT_TRUE(input);
    const OIIO::ImageSpec& spec = input->spec();
    ASSERT_EQ(spec.width, 3);
    ASSERT_EQ(spec.height, 2);
    std::vector<float> values(static_cast<std::size_t>(6 * spec.nchannels));
    ASSERT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data()));
    const auto value = [&](std::size_t pixel, const char* channel) {
        const int at = spec.channelindex(channel);
        EXPECT_GE(at, 0) << channel;
        return values[pixel * static_cast<std::size_t>(spec.nchannels) + static_cast<std::size_t>(at)];
    };
    EXPECT_EQ(value(4, "R"), 4);
    EXPECT_EQ(value(4, "G"), 4e6f);
    EXPECT_EQ(value(4, "B"), -0.25f);
    EXPECT_EQ(value(5, "illuminance_lx"), 105);
    EXPECT_FLOAT_EQ(value(5, "relative_error"), 0.05f);
    EXPECT_EQ(value(5, "hit_count"), 25);
}

TEST_F(PictureFile, WhatCannotBeWrittenIsASentenceAndLeavesNothing) {
    const std::vector<std::uint8_t> rgb(18);
    const auto nowhere = write_exr(folder_ / "missing" / "view.exr", sample());
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().code, ErrorCode::failed);
    EXPECT_NE(nowhere.error().sentence.find("missing/view.exr"), std::string::npos);
    std::filesystem::create_directories(folder_ / "taken.png");
    EXPECT_FALSE(write_png(folder_ / "taken.png", 3, 2, rgb));
    const auto ending = write_png(folder_ / "view.txt", 3, 2, rgb);
    ASSERT_FALSE(ending);
    EXPECT_EQ(ending.error().code, ErrorCode::bad_input);
    EXPECT_EQ(files(), 1u);
}

TEST(ToneMap, KeepsTheOrderOfLuminancesAndGreysGrey) {
    Picture picture{64, 1, std::vector<Pixel>(64)};
    for (std::size_t i = 0; i < 64; ++i) {
        const float value = 0.01f * std::pow(1.3f, static_cast<float>(i));
        picture.pixels[i].radiance = {value, value, value};
    }
    const auto bytes = tone_map(picture, {1, {1, 1, 1}});
    for (std::size_t i = 0; i < 64; ++i) {
        EXPECT_NEAR(bytes[3 * i], bytes[3 * i + 1], 1);
        EXPECT_NEAR(bytes[3 * i], bytes[3 * i + 2], 1);
        if (i > 0) {
            EXPECT_GE(bytes[3 * i], bytes[3 * i - 3]);
        }
    }
    EXPECT_LT(bytes[0], 30);
    EXPECT_GT(bytes[3 * 63], 250);
}

TEST(ToneMap, ExposesWhatIsLitAndNotTheLamp) {
    Picture picture{10, 1, std::vector<Pixel>(10)};
    for (std::size_t i = 0; i < 9; ++i) {
        picture.pixels[i].radiance = {100, 100, 100};
        picture.pixels[i].illuminance_lx = 400;
    }
    picture.pixels[9].radiance = {1e6f, 1e6f, 1e6f};
    picture.pixels[9].illuminance_lx = 400;
    EXPECT_NEAR(automatic_tone(picture, {1, 1, 1}).exposure, 0.007, 1e-4);
}

TEST(ToneMap, AWarmLampTurnsNearlyWhite) {
    Picture picture{1, 1, std::vector<Pixel>(1)};
    picture.pixels[0].radiance = {0.7f, 0.4f, 0.15f};
    const auto plain = tone_map(picture, {1, {1, 1, 1}});
    const auto adapted = tone_map(picture, {1, {0.7, 0.4, 0.15}});
    EXPECT_GT(plain[0] - plain[2], 80);
    EXPECT_LT(adapted[0] - adapted[2], 40);
    EXPECT_GT(adapted[0], adapted[2]) << "a little of the lamp's colour stays";
}

TEST(ToneMap, ColoursOutOfGamutStayWithinBytes) {
    Picture picture{2, 1, std::vector<Pixel>(2)};
    picture.pixels[0].radiance = {5, -1, 0.1f};
    picture.pixels[1].radiance = {-1, 0.2f, 3};
    const auto bytes = tone_map(picture, {1, {1, 1, 1}});
    EXPECT_GT(bytes[0], bytes[1]);
    EXPECT_GT(bytes[5], bytes[3]);
}

}  // namespace
}  // namespace lumenfarm
