#include "common/transport/ray_log.h"
#include "tests/physics/simulate.h"
#include "tests/scenes/scene_builder.h"

#include <numbers>

// The first table of the oracles: enclosures, where geometry drops out.
namespace lumenfarm::testing {
namespace {

constexpr double pi = std::numbers::pi;

Scene furnace(double albedo, double luminance) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(albedo), true);
    for (std::uint32_t s = 0; s < 6; ++s) b.surface_light(s, luminance);
    return b.scene;
}

class Furnace : public ::testing::TestWithParam<double> {};

TEST_P(Furnace, UniformExitanceGivesTheSameIlluminanceOnEveryWall) {
    const double albedo = GetParam();
    const Scene scene = furnace(albedo, 100);
    const Simulated s = simulate(scene, particles(albedo > 0.9 ? 800'000 : 1'200'000));
    for (std::size_t w = 0; w < s.surfaces.size(); ++w)
        expect_illuminance(s.surfaces[w].total, pi * 100 / (1 - albedo), 0.003, scene.surfaces[w].name);
}

TEST_P(Furnace, ParticlesHitOneOverOneMinusAlbedoTimes) {
    const double albedo = GetParam();
    const Simulated s = simulate(furnace(albedo, 100), particles(400'000));
    const double mean = static_cast<double>(s.solution.balance.hits) / 400'000;
    // hits are geometric: variance albedo / (1 - albedo)^2
    const double error = std::sqrt(albedo) / (1 - albedo) / std::sqrt(400'000);
    expect_oracle(mean, error, 1 / (1 - albedo), 0.003, "hits a particle");
    EXPECT_EQ(s.solution.balance.escaped, 0);
}

INSTANTIATE_TEST_SUITE_P(Albedos, Furnace, ::testing::Values(0.5, 0.8, 0.95));

TEST(Enclosure, AreaMeanIsFluxOverAbsorbingAreaWhateverTheShape) {
    SceneBuilder b;
    const std::uint32_t white = b.lambert(0.7);
    b.box("room", {0, 0, 0}, {4, 2.5f, 3}, white, true);
    b.box("block", {1, 0, 1}, {1.5f, 1.2f, 1.7f}, white, false);
    b.sphere("ball", {3, 1, 2}, 0.4f, 16, white);
    b.point_light({0.7, 2, 2.2}, 300);
    const Simulated s = simulate(b.scene, particles(1'500'000));
    // the block's bottom lies on the floor: neither it nor what it covers is reached
    double area = 0;
    for (std::uint32_t t = 0; t < b.scene.triangles.size(); ++t) area += triangle_area_m2(b.scene, t);
    const double hidden = 2 * 0.5 * 0.7;
    AreaEstimate mean = area_mean(s);
    const double scale = area / (area - hidden);
    expect_oracle(mean.illuminance_lx * scale, mean.standard_error_lx * scale,
                  4 * pi * 300 / ((area - hidden) * (1 - 0.7)), 0.003, "area mean");
    EXPECT_EQ(s.solution.balance.escaped, 0);
}

TEST(Enclosure, AttenuatedEnergyGivesTheSameMean) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {4, 2.5f, 3}, b.lambert(0.6), true);
    b.point_light({0.7, 2, 2.2}, 300);
    JobSpec spec = particles(400'000);
    spec.absorption = Absorption::attenuate;
    spec.cutoff = 0.05;
    const Simulated s = simulate(b.scene, spec);
    const double area = 2 * (4 * 2.5 + 4 * 3 + 2.5 * 3);
    const AreaEstimate mean = area_mean(s);
    expect_oracle(mean.illuminance_lx, mean.standard_error_lx, 4 * pi * 300 / (area * 0.4), 0.003,
                  "roulette is unbiased");
}

TEST(Enclosure, PlainCutoffBooksWhatItLoses) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.5), true);
    b.point_light({0.3, 0.4, 0.5}, 10);
    JobSpec spec = particles(20'000);
    spec.absorption = Absorption::attenuate;
    spec.cutoff_rule = CutoffRule::plain;
    spec.cutoff = 0.2;
    const Simulated s = simulate(b.scene, spec);
    // 1, 0.5, 0.25 go on; 0.125 is under the threshold and is cut off
    const double lost =
        static_cast<double>(s.solution.balance.cut_off) / static_cast<double>(s.solution.balance.emitted);
    EXPECT_NEAR(lost, 0.125, 1e-4);
    EXPECT_EQ(s.solution.balance.hits, 3u * 20'000u);
}

TEST(Enclosure, SphereSpreadsIndirectLightEvenly) {
    SceneBuilder b;
    const std::uint32_t white = b.lambert(0.8);
    const std::uint32_t source = b.lambert(0.8);
    b.sphere("sphere", {0, 0, 0}, 1, 96, white, true);
    // halves as surfaces of their own, so that evenness shows
    const std::uint32_t half = b.scene.surfaces[0].triangle_count / 2;
    b.scene.surfaces.push_back({"lower", "lower", half, b.scene.surfaces[0].triangle_count - half, source});
    b.scene.surfaces[0].triangle_count = half;
    b.point_light({0.3, 0.5, -0.2}, 100);
    const Simulated s = simulate(b.scene, particles(3'000'000));
    const Simulated direct = [&] {
        SceneBuilder black = b;
        black.scene.spectra[black.scene.materials[white].diffuse.spectrum] = constant_spectrum(0);
        black.scene.spectra[black.scene.materials[source].diffuse.spectrum] = constant_spectrum(0);
        return simulate(black.scene, particles(3'000'000));
    }();
    const double truth = 0.8 * 400 * pi / (4 * pi * 0.2);
    for (std::size_t i = 0; i < 2; ++i) {
        const AreaEstimate& all = s.surfaces[i].total;
        const AreaEstimate& first = direct.surfaces[i].total;
        // 96 slices: the mesh has 0.06 % less area than the sphere
        const double area_ratio = all.area_m2 / (2 * pi);
        expect_oracle((all.illuminance_lx - first.illuminance_lx) * area_ratio,
                      std::hypot(all.standard_error_lx, first.standard_error_lx), truth, 0.003, "indirect");
    }
}

/// Mean length of the first flight of particles that leave the walls by the cosine law.
double mean_segment(const Scene& scene, std::uint64_t per_light, double& error) {
    const auto tracer = std::move(TracerScene::make(scene).value());
    double sum = 0;
    double squares = 0;
    std::uint64_t count = 0;
    for (std::uint32_t light = 0; light < scene.lights.size(); ++light) {
        TracedHits hits;
        RayLog rays;
        tracer->trace(particles(1), {light, 0, per_light}, hits, &rays);
        for (const Ray& ray : rays) {
            const auto meeting = tracer->meet(ray.origin, ray.direction, ray.from_triangle);
            sum += meeting.distance;
            squares += meeting.distance * meeting.distance;
            ++count;
        }
    }
    const double mean = sum / static_cast<double>(count);
    error = std::sqrt((squares / static_cast<double>(count) - mean * mean) / static_cast<double>(count));
    return mean;
}

TEST(Enclosure, MeanSegmentIsFourVolumesOverSurface) {
    double error = 0;
    const double cube = mean_segment(furnace(0, 100), 100'000, error);
    expect_oracle(cube, error, 2.0 / 3, 0.003, "unit cube");

    SceneBuilder b;
    b.sphere("sphere", {0, 0, 0}, 1, 128, b.lambert(0), true);
    b.surface_light(0, 100);
    const double sphere = mean_segment(b.scene, 500'000, error);
    expect_oracle(sphere, error, 4.0 / 3, 0.003, "unit sphere");
}

}  // namespace
}  // namespace lumenfarm::testing
