#include "common/spectrum/upsample.h"

#include "common/spectrum/cie.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace lumenfarm {
namespace {

constexpr double levels[] = {0, 1e-3, 0.02, 0.1, 0.3, 0.5, 0.8, 0.95, 1};

/// XYZ of a spectrum of reflected D65, Y = 1 for D65 itself.
template <class Reflectance>
Vec3d xyz_under_d65(Reflectance reflectance) {
    Vec3d xyz;
    double white = 0;
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) {
        const double light = value_at(illuminant_d65(), bin);
        const Vec3d observer{value_at(cie_x(), bin), value_at(cie_y(), bin), value_at(cie_z(), bin)};
        xyz = xyz + observer * (light * reflectance(bin));
        white += light * observer.y;
    }
    return xyz * (1 / white);
}

double largest_difference(Vec3d a, Vec3d b) {
    return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

Vec3d encoded(Vec3d rgb) { return {srgb_encode(rgb.x), srgb_encode(rgb.y), srgb_encode(rgb.z)}; }

TEST(Upsample, EveryColourOfAGridComesBack) {
    for (const double r : levels)
        for (const double g : levels)
            for (const double b : levels) {
                const Vec3d rgb{r, g, b};
                const Spectrum table = reflectance_spectrum(rgb);
                const Vec3d xyz = xyz_under_d65([&](std::uint32_t bin) { return value_at(table, bin); });
                EXPECT_LT(largest_difference(xyz_to_linear_srgb(xyz), rgb), 1e-3) << r << ' ' << g << ' ' << b;
                EXPECT_LT(largest_difference(encoded(xyz_to_linear_srgb(xyz)), encoded(rgb)), 1e-3)
                    << r << ' ' << g << ' ' << b;
            }
}

TEST(Upsample, CoefficientsGiveTheSameCurveAsTheTable) {
    for (const Vec3d rgb : {Vec3d{0.9, 0.1, 0.05}, Vec3d{0.2, 0.7, 0.3}, Vec3d{0.05, 0.1, 0.6}, Vec3d{0.4, 0.4, 0.4}}) {
        const Spectrum table = reflectance_spectrum(rgb);
        const SigmoidCoefficients c = reflectance_coefficients(rgb);
        for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin)
            ASSERT_NEAR(reflectance_at(c, bin), value_at(table, bin), 2e-3) << bin;
        const Vec3d xyz = xyz_under_d65([&](std::uint32_t bin) { return reflectance_at(c, bin); });
        EXPECT_LT(largest_difference(xyz_to_linear_srgb(xyz), rgb), 1e-3);
    }
}

TEST(Upsample, EveryReflectanceLiesBetweenZeroAndOne) {
    for (const double r : levels)
        for (const double g : levels) {
            const SigmoidCoefficients c = reflectance_coefficients({r, g, 0.5});
            for (std::uint32_t bin = 0; bin < wavelength_bins; bin += 7) {
                ASSERT_GE(reflectance_at(c, bin), 0);
                ASSERT_LE(reflectance_at(c, bin), 1);
            }
        }
    for (const float c2 : {3e38f, -3e38f}) {
        const double value = reflectance_at({3e38f, 0, c2}, 17);
        EXPECT_TRUE(value >= 0 && value <= 1);
    }
}

TEST(Upsample, GreyIsConstantToTheBit) {
    for (const double grey : {1e-6, 0.02, 0.18, 0.5, 0.78, 0.999999}) {
        const SigmoidCoefficients c = reflectance_coefficients({grey, grey, grey});
        EXPECT_EQ(c.c0, 0.0f);
        EXPECT_EQ(c.c1, 0.0f);
        const double first = reflectance_at(c, 0);
        EXPECT_NEAR(first, grey, 1e-6 * grey);
        for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) ASSERT_EQ(reflectance_at(c, bin), first);
        EXPECT_EQ(reflectance_spectrum({grey, grey, grey}), constant_spectrum(grey));
    }
}

TEST(Upsample, BlackAndWhiteAreExact) {
    for (const std::uint32_t bin : {0u, 1999u, 3999u}) {
        EXPECT_EQ(reflectance_at(reflectance_coefficients({0, 0, 0}), bin), 0.0);
        EXPECT_EQ(reflectance_at(reflectance_coefficients({1, 1, 1}), bin), 1.0);
        EXPECT_EQ(reflectance_at(reflectance_coefficients({7, 7, 9}), bin), 1.0) << "clamped to white";
        EXPECT_EQ(reflectance_at(reflectance_coefficients({-1, -2, -3}), bin), 0.0) << "clamped to black";
    }
    EXPECT_EQ(reflectance_spectrum({0, 0, 0}), constant_spectrum(0));
    EXPECT_EQ(reflectance_spectrum({1, 1, 1}), constant_spectrum(1));
}

TEST(Upsample, LightHasChromaticityAndLuminanceOfItsColour) {
    for (const Vec3d rgb : {Vec3d{17, 12, 4}, Vec3d{1, 0, 0}, Vec3d{0, 0.3, 0}, Vec3d{0, 0, 1}, Vec3d{1, 0.9, 0.8}}) {
        const Spectrum light = light_spectrum(rgb);
        const double white = integral(illuminant_d65(), cie_y());
        const Vec3d xyz =
            Vec3d{integral(light, cie_x()), integral(light, cie_y()), integral(light, cie_z())} * (1 / white);
        const Vec3d target = rgb * (1 / std::max({rgb.x, rgb.y, rgb.z}));
        EXPECT_LT(largest_difference(xyz_to_linear_srgb(xyz), target), 2e-3) << rgb.x << ' ' << rgb.y << ' ' << rgb.z;
        EXPECT_NEAR(xyz.y, linear_srgb_to_xyz(target).y, 1e-3);
    }
}

TEST(Upsample, WhiteLightIsD65) {
    EXPECT_EQ(light_spectrum({1, 1, 1}), illuminant_d65());
    EXPECT_EQ(light_spectrum({40, 40, 40}), illuminant_d65());
}

}  // namespace
}  // namespace lumenfarm
