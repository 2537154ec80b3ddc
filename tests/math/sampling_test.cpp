#include "common/math/sampling.h"
#include "common/math/philox.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace lumenfarm {
namespace {

constexpr double pi = std::numbers::pi;

/// Chi-square of directions about +z against a density, over 20 x 20 cells of (cos theta, phi) with cos theta in
/// [low, 1]; cells that expect fewer than 25 are left out. Returns the statistic's distance from its mean in standard
/// deviations.
double chi_square_excess(const std::function<Vec3d(std::uint32_t)>& sample, const std::function<double(Vec3d)>& pdf,
                         double low) {
    constexpr int cells = 20;
    constexpr int count = 200'000;
    std::vector<double> seen(cells * cells);
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3d d = sample(i);
        const double turns = std::atan2(d.y, d.x) / (2 * pi);
        const int row = std::min(cells - 1, static_cast<int>((d.z - low) / (1 - low) * cells));
        const int column = std::min(cells - 1, static_cast<int>((turns < 0 ? turns + 1 : turns) * cells));
        EXPECT_GE(row, 0);
        seen[static_cast<std::size_t>(std::max(row, 0) * cells + column)] += 1;
    }
    double chi = 0;
    int freedom = -1;
    for (int row = 0; row < cells; ++row) {
        double expected = 0;
        constexpr int steps = 400;
        for (int k = 0; k < steps; ++k) {
            const double z = low + (1 - low) * (row + (k + 0.5) / steps) / cells;
            const double r = std::sqrt(1 - z * z);
            expected += pdf({r, 0, z}) * (1 - low) / cells / steps * 2 * pi / cells * count;
        }
        for (int column = 0; column < cells; ++column) {
            if (expected < 25) continue;
            const double difference = seen[static_cast<std::size_t>(row * cells + column)] - expected;
            chi += difference * difference / expected;
            ++freedom;
        }
    }
    EXPECT_GT(freedom, 50);
    return (chi - freedom) / std::sqrt(2.0 * freedom);
}

std::array<double, 4> four(std::uint32_t i) {
    const auto r = philox(5, {i, 0, 0, 0});
    return {uniform(r[0]), uniform(r[1]), uniform(r[2]), uniform(r[3])};
}

TEST(Sampling, CosineHemisphereFollowsItsDensity) {
    const auto sample = [](std::uint32_t i) { return sample_cosine_hemisphere(four(i)[0], four(i)[1]); };
    EXPECT_LT(chi_square_excess(sample, pdf_cosine_hemisphere, 0), 4);
}

TEST(Sampling, UniformZoneFollowsItsDensity) {
    const auto sample = [](std::uint32_t i) { return sample_uniform_zone(four(i)[0], four(i)[1], -1, 1); };
    EXPECT_LT(chi_square_excess(
                  sample, [](Vec3d d) { return pdf_uniform_zone(d, -1, 1); }, -1),
              4);
}

TEST(Sampling, SpotFollowsItsDensity) {
    const auto sample = [](std::uint32_t i) {
        const auto u = four(i);
        return sample_spot(u[0], u[1], u[2], u[3], 0.9, 0.5);
    };
    EXPECT_LT(chi_square_excess(
                  sample, [](Vec3d d) { return pdf_spot(d, 0.9, 0.5); }, 0.5),
              4);
}

TEST(Sampling, ChiSquareSeesAWrongDensity) {
    const auto sample = [](std::uint32_t i) { return sample_cosine_hemisphere(four(i)[0], four(i)[1]); };
    EXPECT_GT(chi_square_excess(
                  sample, [](Vec3d d) { return pdf_uniform_zone(d, 0, 1); }, 0),
              100);
}

TEST(Sampling, SineAndCosineAreThoseOfTheLibrary) {
    for (int i = 0; i <= 100'000; ++i) {
        const double turns = i / 100'000.0;
        const auto sc = sin_cos_turns(turns);
        ASSERT_NEAR(sc.sin, std::sin(2 * pi * turns), 1e-11);
        ASSERT_NEAR(sc.cos, std::cos(2 * pi * turns), 1e-11);
    }
}

TEST(Sampling, FrameIsOrthonormalAndRightHanded) {
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const Vec3d n = sample_uniform_zone(four(i)[0], four(i)[1], -1, 1);
        const auto f = frame_about(n);
        ASSERT_NEAR(length(f.tangent), 1, 1e-10);
        ASSERT_NEAR(dot(f.tangent, f.normal), 0, 1e-10);
        ASSERT_NEAR(dot(cross(f.tangent, f.bitangent), f.normal), 1, 1e-10);
    }
}

TEST(Sampling, TrianglePointsAreUniform) {
    double b1 = 0;
    double corner = 0;
    for (std::uint32_t i = 0; i < 100'000; ++i) {
        const Barycentrics b = sample_triangle(four(i)[0], four(i)[1]);
        ASSERT_GE(1 - b.b1 - b.b2, -1e-12);
        b1 += b.b1;
        corner += b.b1 > 0.5;
    }
    EXPECT_NEAR(b1 / 100'000, 1.0 / 3, 4 * std::sqrt(1.0 / 18 / 100'000));
    EXPECT_NEAR(corner / 100'000, 0.25, 4 * std::sqrt(0.25 * 0.75 / 100'000));
}

TEST(Sampling, CosineDirectionsAboutANormalAreUnitAndLeaveItsSide) {
    for (std::uint32_t i = 0; i < 20'000; ++i) {
        const Vec3d n = sample_uniform_zone(four(i)[0], four(i)[1], -1, 1);
        const auto r = philox(17, {i, 0, 0, 0});
        const Vec3d d = sample_cosine_about(n, uniform_float(i % 10 == 0 ? ~0u : r[0]), uniform_float(r[1]));
        ASSERT_NEAR(length(d), 1, 1e-12);
        ASSERT_GT(dot(d, n), 1e-4);
    }
}

TEST(Sampling, CosineDirectionsAboutANormalAreThoseOfTheHemisphereTurned) {
    // moments about the normal: E cos = 2/3, E cos^2 = 1/2, and none across it
    const Vec3d n = normalize(Vec3d{0.3, -0.8, -0.5});
    constexpr std::uint32_t count = 400'000;
    double first = 0;
    double second = 0;
    Vec3d sum;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto r = philox(18, {i, 0, 0, 0});
        const Vec3d d = sample_cosine_about(n, uniform_float(r[0]), uniform_float(r[1]));
        first += dot(d, n) / count;
        second += dot(d, n) * dot(d, n) / count;
        sum = sum + d * (1.0 / count);
    }
    EXPECT_NEAR(first, 2.0 / 3, 4 * std::sqrt(1.0 / 18 / count));
    EXPECT_NEAR(second, 0.5, 4 * std::sqrt(1.0 / 12 / count));
    EXPECT_NEAR(length(sum - n * first), 0, 4 * std::sqrt(0.5 / count));
}

}  // namespace
}  // namespace lumenfarm
