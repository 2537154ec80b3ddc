#include "tests/physics/simulate.h"
#include "tests/scenes/scene_builder.h"

#include <numbers>

// The direct-light table of the oracles: closed forms of one flight.
namespace lumenfarm::testing {
namespace {

constexpr double pi = std::numbers::pi;

/// Solid angle of a rectangle 2a x 2b at distance d on its axis [sr].
double solid_angle_sr(double a, double b, double d) {
    return 4 * std::asin(a * b / std::sqrt((a * a + d * d) * (b * b + d * d)));
}

/// Illuminance at a point by Lambert's edge sum for a uniform polygon of luminance L (corners counter-clockwise as seen
/// from the point) [Lambert 1760; Baum et al. 1989].
double edge_sum_lx(const std::vector<Vec3d>& corners, Vec3d point, Vec3d normal, double luminance) {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3d a = normalize(corners[i] - point);
        const Vec3d b = normalize(corners[(i + 1) % corners.size()] - point);
        const Vec3d gamma = cross(a, b);
        sum += std::acos(dot(a, b)) * dot(normalize(gamma), normal);
    }
    return std::abs(luminance / 2 * sum);
}

TEST(DirectLight, PointSourceLightsAPlateByItsSolidAngle) {
    SceneBuilder b;
    b.surface("plate", b.lambert(0));
    b.quad({-0.5f, 0, 0.5f}, {0.5f, 0, 0.5f}, {0.5f, 0, -0.5f}, {-0.5f, 0, -0.5f});
    b.point_light({0, 2, 0}, 1000);
    const Simulated s = simulate(b.scene, particles(8'000'000));
    expect_illuminance(s.surfaces[0].front, 1000 * solid_angle_sr(0.5, 0.5, 2), 0.003, "plate");
    EXPECT_EQ(s.surfaces[0].back.hits, 0u);
}

TEST(DirectLight, PointSourceFallsWithTheSquareOfTheDistanceAndTheCosine) {
    SceneBuilder b;
    b.surface("tilted", b.lambert(0));
    // 0.4 m square at 1.5 m, tilted by 40 degrees
    const double c = std::cos(40 * pi / 180) * 0.2;
    const double s40 = std::sin(40 * pi / 180) * 0.2;
    b.quad(Vec3d{-0.2, -s40, c}.as<float>(), Vec3d{0.2, -s40, c}.as<float>(), Vec3d{0.2, s40, -c}.as<float>(),
           Vec3d{-0.2, s40, -c}.as<float>());
    b.point_light({0, 1.5, 0}, 500);
    const Simulated s = simulate(b.scene, particles(28'000'000));
    // mean of I cos / d^2 over the square by the midpoint rule
    double truth = 0;
    const int n = 64;
    const Vec3d u{0.4, 0, 0};
    const Vec3d v{0, 2 * s40, -2 * c};
    const Vec3d normal = normalize(cross(u, v));
    for (int i = 0; i < n * n; ++i) {
        const Vec3d p = u * ((i % n + 0.5) / n - 0.5) + v * ((i / n + 0.5) / n - 0.5);
        const Vec3d to = Vec3d{0, 1.5, 0} - p;
        truth += 500 * dot(normal, to) / std::pow(length(to), 3) / (n * n);
    }
    expect_illuminance(s.surfaces[0].front, truth, 0.003, "tilted plate");
}

TEST(DirectLight, SpotKeepsItsFluxInsideTheCone) {
    SceneBuilder b;
    b.surface("floor", b.lambert(0));
    b.quad({-5, 0, 5}, {5, 0, 5}, {5, 0, -5}, {-5, 0, -5});
    b.surface("target", b.lambert(0));
    b.quad({-0.1f, 0.01f, 0.1f}, {0.1f, 0.01f, 0.1f}, {0.1f, 0.01f, -0.1f}, {-0.1f, 0.01f, -0.1f});
    Light spot;
    spot.name = "spot";
    spot.kind = LightKind::spot;
    spot.position = {0, 2, 0};
    spot.direction = {0, -1, 0};
    spot.cos_inner = std::cos(0.3);
    spot.cos_outer = std::cos(0.5);
    spot.photometric = 800;
    spot.spectrum = b.spectrum(1);
    b.scene.lights.push_back(spot);
    const Simulated s = simulate(b.scene, particles(20'000'000));
    expect_illuminance(s.surfaces[1].front, 800 * solid_angle_sr(0.1, 0.1, 1.99) / 0.04, 0.003, "axis of the spot");
    EXPECT_EQ(s.solution.balance.escaped, 0);
    // all of it arrives: 2 pi I ((1 - c_i) + (c_i - c_o) / 3)
    const double flux = 800 * 2 * pi * ((1 - spot.cos_inner) + (spot.cos_inner - spot.cos_outer) / 3);
    const double arrived = s.surfaces[0].total.illuminance_lx * 100 + s.surfaces[1].total.illuminance_lx * 0.04;
    EXPECT_NEAR(arrived / flux, 1, 1e-3);
}

double exchanged_fraction(const Scene& scene, double& error) {
    const Simulated s = simulate(scene, particles(3'000'000));
    const double flux = s.tracer->emission().flux_lm;
    error = s.surfaces[1].total.standard_error_lx / flux;
    return s.surfaces[1].total.illuminance_lx / flux;
}

Scene facing_squares(float gap) {
    SceneBuilder b;
    b.surface("source", b.lambert(0));
    b.quad({0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {0, 0, 0});
    b.surface("receiver", b.lambert(0));
    b.quad({0, gap, 0}, {1, gap, 0}, {1, gap, 1}, {0, gap, 1});
    b.surface_light(0, 1000);
    return b.scene;
}

TEST(DirectLight, ParallelSquaresExchangeTheirFormFactor) {
    double error = 0;
    const double one = exchanged_fraction(facing_squares(1), error);
    expect_oracle(one, error, 0.199825, 0.003, "gap 1");
    const double half = exchanged_fraction(facing_squares(0.5f), error);
    expect_oracle(half, error, 0.415253, 0.003, "gap 0.5");
}

TEST(DirectLight, PerpendicularSquaresExchangeTheirFormFactor) {
    SceneBuilder b;
    b.surface("source", b.lambert(0));
    b.quad({0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {0, 0, 0});
    b.surface("receiver", b.lambert(0));
    b.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    b.surface_light(0, 1000);
    double error = 0;
    const double fraction = exchanged_fraction(b.scene, error);
    expect_oracle(fraction, error, 0.200044, 0.003, "common edge");
}

TEST(DirectLight, PolygonSourceFollowsLambertsEdgeSum) {
    SceneBuilder b;
    b.surface("source", b.lambert(0));
    const std::vector<Vec3d> corners{{-0.4, 1.5, -0.3}, {0.5, 1.5, -0.5}, {0.7, 1.5, 0.4}};
    b.triangle(corners[0].as<float>(), corners[1].as<float>(), corners[2].as<float>());
    b.surface("receiver", b.lambert(0));
    b.quad({0.2f, 0, 0.6f}, {0.6f, 0, 0.6f}, {0.6f, 0, 0.2f}, {0.2f, 0, 0.2f});
    b.surface_light(0, 2000);
    const Simulated s = simulate(b.scene, particles(8'000'000));
    ASSERT_LT(triangle_cross(b.scene, 0).y, 0) << "the source faces down";
    double truth = 0;
    const int n = 32;
    for (int i = 0; i < n * n; ++i)
        truth +=
            edge_sum_lx(corners, {0.2 + 0.4 * (i % n + 0.5) / n, 0, 0.2 + 0.4 * (i / n + 0.5) / n}, {0, 1, 0}, 2000) /
            (n * n);
    expect_illuminance(s.surfaces[1].front, truth, 0.003, "receiver");
}

TEST(DirectLight, DoubleSidedSourceLightsBothSidesAlike) {
    SceneBuilder b;
    const std::uint32_t lamp = b.lambert(0);
    b.scene.materials[lamp].double_sided = true;
    b.surface("source", lamp);
    b.quad({0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {0, 0, 0});
    b.surface("above", b.lambert(0));
    b.quad({0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1});
    b.surface("below", b.lambert(0));
    b.quad({0, -1, 1}, {1, -1, 1}, {1, -1, 0}, {0, -1, 0});
    b.surface_light(0, 1000);
    const Simulated s = simulate(b.scene, particles(4'000'000));
    expect_illuminance(s.surfaces[1].total, pi * 1000 * 0.199825, 0.003, "above");
    expect_illuminance(s.surfaces[2].total, pi * 1000 * 0.199825, 0.003, "below");
}

class CubeOf : public ::testing::TestWithParam<double> {};

TEST_P(CubeOf, TenThousandLumenGivesTheIndirectIlluminanceOfCie171Case58) {
    const double albedo = GetParam();
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {4, 4, 4}, b.lambert(albedo), true);
    b.point_light({2, 2, 2}, 10'000 / (4 * pi));
    const Simulated s = simulate(b.scene, particles(albedo > 0.9 ? 1'600'000 : 2'000'000));
    const AreaEstimate mean = area_mean(s);
    // what arrives first is 10,000 lm over 96 m2, exactly; the rest is indirect
    const double indirect = mean.illuminance_lx - 104.1667;
    expect_oracle(indirect, mean.standard_error_lx, albedo * 104.1667 / (1 - albedo), 0.003, "indirect");
}

INSTANTIATE_TEST_SUITE_P(Albedos, CubeOf, ::testing::Values(0.5, 0.8, 0.95));

}  // namespace
}  // namespace lumenfarm::testing
