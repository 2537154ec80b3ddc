#include "common/spectrum/cie.h"

#include <gtest/gtest.h>

namespace lumenfarm {
namespace {

TEST(Spectrum, InterpolatesBetweenSamplesAndContinuesBeyondTheEnds) {
    Spectrum ramp;
    for (std::size_t i = 0; i < spectrum_samples; ++i) ramp.samples[i] = static_cast<float>(i);
    EXPECT_DOUBLE_EQ(value_at_nm(ramp, 380), 0);
    EXPECT_DOUBLE_EQ(value_at_nm(ramp, 381), 0.2);
    EXPECT_DOUBLE_EQ(value_at_nm(ramp, 555), 35);
    EXPECT_DOUBLE_EQ(value_at_nm(ramp, 780), 80);
    EXPECT_DOUBLE_EQ(value_at_nm(ramp, 100), 0);
    EXPECT_DOUBLE_EQ(value_at_nm(ramp, 2000), 80);
    for (const std::uint32_t bin : {0u, 49u, 50u, 1777u, 3999u})
        EXPECT_NEAR(value_at(ramp, bin), value_at_nm(ramp, wavelength_nm(bin)), 1e-11) << bin;
}

TEST(Spectrum, ConstantIsTheSameInEveryBinToTheBit) {
    const Spectrum grey = constant_spectrum(0.3);
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) ASSERT_EQ(value_at(grey, bin), double{0.3f});
}

TEST(Cie, FunctionsHaveEqualIntegralsOfThePublishedValue) {
    // Sums over the 5 nm table times 5 nm; the trapezoid loses half of each end value.
    const auto table_sum = [](const Spectrum& s) {
        return integral(s) + 2.5 * (double{s.samples.front()} + double{s.samples.back()});
    };
    EXPECT_NEAR(table_sum(cie_x()), 106.857, 0.002);
    EXPECT_NEAR(table_sum(cie_y()), 106.857, 0.002);
    EXPECT_NEAR(table_sum(cie_z()), 106.857, 0.002);
}

TEST(Cie, VisibilityPeaksAtOneAt555Nanometres) {
    EXPECT_EQ(value_at_nm(cie_y(), 555), 1.0);
    for (const float value : cie_y().samples) EXPECT_LE(value, 1.0f);
}

TEST(Cie, D65HasThePublishedChromaticity) {
    const double x = integral(illuminant_d65(), cie_x());
    const double y = integral(illuminant_d65(), cie_y());
    const double z = integral(illuminant_d65(), cie_z());
    EXPECT_NEAR(x / (x + y + z), 0.3127, 1e-4);
    EXPECT_NEAR(y / (x + y + z), 0.3290, 1e-4);
    EXPECT_EQ(value_at_nm(illuminant_d65(), 560), 100.0);
}

TEST(Cie, EfficacyOfEqualEnergyAndOfALineNear555) {
    EXPECT_NEAR(efficacy_lm_w(constant_spectrum(1)), 683 * 106.857 / 400, 0.01);
    EXPECT_NEAR(efficacy_lm_w(constant_spectrum(7)), efficacy_lm_w(constant_spectrum(1)), 1e-9);
    Spectrum line;
    line.samples[35] = 1;  // a triangle over 550..560 nm
    // V falls by 0.00505 and 0.005 to its neighbours; the mean distance from the peak is a third of a step
    EXPECT_NEAR(efficacy_lm_w(line), 683 * (1 - 0.005025 / 3), 0.02);
}

TEST(Cie, SrgbMatricesAreInverseAndWhiteIsD65) {
    for (const Vec3d rgb : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{0.2, 0.5, 0.9}}) {
        const Vec3d back = xyz_to_linear_srgb(linear_srgb_to_xyz(rgb));
        EXPECT_NEAR(back.x, rgb.x, 1e-12);
        EXPECT_NEAR(back.y, rgb.y, 1e-12);
        EXPECT_NEAR(back.z, rgb.z, 1e-12);
    }
    const Vec3d white = linear_srgb_to_xyz({1, 1, 1});
    EXPECT_NEAR(white.x / (white.x + white.y + white.z), 0.3127, 1e-9);
    EXPECT_NEAR(white.y / (white.x + white.y + white.z), 0.3290, 1e-9);
    EXPECT_NEAR(white.y, 1, 1e-12);
    EXPECT_NEAR(linear_srgb_to_xyz({1, 0, 0}).x / 0.4124, 1, 1e-3);
}

TEST(Cie, TransferCurveRoundTripsAndClamps) {
    for (int i = 0; i <= 1000; ++i) EXPECT_NEAR(srgb_decode(srgb_encode(i / 1000.0)), i / 1000.0, 1e-6);
    EXPECT_NEAR(srgb_encode(0.2140411), 0.5, 1e-6);
    EXPECT_NEAR(srgb_encode(0.001), 0.01292, 1e-9);
    EXPECT_EQ(srgb_encode(-1), 0);
    EXPECT_EQ(srgb_encode(7), 1);
    EXPECT_EQ(srgb_decode(2), 1);
}

}  // namespace
}  // namespace lumenfarm
