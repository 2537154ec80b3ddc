#include "common/transport/fresnel.h"
#include "common/transport/ray_log.h"
#include "tests/physics/simulate.h"
#include "tests/scenes/scene_builder.h"

#include <numbers>

// Fresnel and prism rows of the oracles.
namespace lumenfarm::testing {
namespace {

constexpr double degree = std::numbers::pi / 180;

TEST(Fresnel, ReflectanceOfGlassFollowsTheTable) {
    const std::pair<double, double> rows[] = {{0, 0.04000},  {30, 0.04152}, {45, 0.05024},
                                              {60, 0.08919}, {75, 0.25306}, {85, 0.61280}};
    for (const auto& [angle, reflectance] : rows)
        EXPECT_NEAR(fresnel(std::cos(angle * degree), 1.5).reflectance, reflectance, 5e-6) << angle;
}

TEST(Fresnel, TotalReflectionStartsAtTheCriticalAngle) {
    EXPECT_LT(fresnel(std::cos(41.810 * degree), 1 / 1.5).reflectance, 1);
    EXPECT_EQ(fresnel(std::cos(41.811 * degree), 1 / 1.5).reflectance, 1);
}

TEST(Fresnel, DiffuseReflectanceOutsideAndInsideAgreeWithReciprocity) {
    const auto diffuse = [](double index) {
        double sum = 0;
        const int n = 200'000;
        for (int i = 0; i < n; ++i) {
            const double cosine = (i + 0.5) / n;
            sum += 2 * cosine * fresnel(cosine, index).reflectance / n;
        }
        return sum;
    };
    EXPECT_NEAR(diffuse(1.5), 0.091778, 2e-6);
    EXPECT_NEAR(diffuse(1 / 1.5), 0.596346, 2e-6);
}

/// A pencil of light onto a horizontal slab of glass at an angle; what passes is counted on the floor.
double slab_transmittance(double angle, bool thin, double& error) {
    SceneBuilder b;
    const std::uint32_t glass = b.glass(1.5, thin);
    if (thin) {
        b.surface("sheet", glass);
        b.quad({-50, 0, 50}, {50, 0, 50}, {50, 0, -50}, {-50, 0, -50});
    } else {
        b.box("slab", {-50, -0.01f, -50}, {50, 0, 50}, glass, false);
    }
    b.surface("floor", b.lambert(0));
    b.quad({-50, -1, 50}, {50, -1, 50}, {50, -1, -50}, {-50, -1, -50});
    Light pencil;
    pencil.name = "pencil";
    pencil.kind = LightKind::spot;
    pencil.direction = {std::sin(angle * degree), -std::cos(angle * degree), 0};
    pencil.position = pencil.direction * -2.0;
    pencil.cos_inner = pencil.cos_outer = std::cos(1e-4);
    pencil.photometric = 1e6;
    pencil.spectrum = b.spectrum(1);
    b.scene.lights.push_back(pencil);
    const std::uint64_t count = 400'000;
    const Simulated s = simulate(b.scene, particles(count));
    std::uint64_t hits = 0;
    const std::size_t floor = b.scene.surfaces.size() - 1;
    for (const auto& batch : s.solution.surfaces[floor][0]) hits += batch.hits;
    const double fraction = static_cast<double>(hits) / static_cast<double>(count);
    error = std::sqrt(fraction * (1 - fraction) / static_cast<double>(count));
    return fraction;
}

TEST(Glass, SlabTransmitsAllOrders) {
    const std::pair<double, double> rows[] = {{0.01, 0.92308}, {45, 0.90433}, {60, 0.83623}};
    for (const auto& [angle, transmittance] : rows) {
        double error = 0;
        const double solid = slab_transmittance(angle, false, error);
        expect_oracle(solid, error, transmittance, 0.003, "solid slab at " + std::to_string(angle));
        const double thin = slab_transmittance(angle, true, error);
        expect_oracle(thin, error, transmittance, 0.003, "thin sheet at " + std::to_string(angle));
    }
}

double bk7(double nm) {
    const double w = nm * nm * 1e-6;
    return std::sqrt(1 + 1.03961212 * w / (w - 0.00600069867) + 0.231792344 * w / (w - 0.0200179144) +
                     1.01046945 * w / (w - 103.560653));
}

/// Deviation of the ray of one wavelength through a 60 degree prism at the angle of incidence of least deviation [deg].
double prism_deviation(double nm) {
    SceneBuilder b;
    const std::uint32_t glass = b.glass(1.5);
    Spectrum index;
    for (std::size_t i = 0; i < spectrum_samples; ++i)
        index.samples[i] = static_cast<float>(bk7(wavelength_min_nm + sample_step_nm * static_cast<double>(i)));
    b.scene.spectra[b.scene.materials[glass].refractive_index] = index;
    const Vec3f apex{0, 0.8660254f, 0};
    const Vec3f left{-0.5f, 0, 0};
    const Vec3f right{0.5f, 0, 0};
    const auto at = [](Vec3f p, float z) { return Vec3f{p.x, p.y, z}; };
    b.surface("prism", glass);
    b.quad(at(left, -1), at(left, 1), at(apex, 1), at(apex, -1));
    b.quad(at(right, 1), at(right, -1), at(apex, -1), at(apex, 1));
    b.quad(at(left, 1), at(left, -1), at(right, -1), at(right, 1));
    b.triangle(at(left, 1), at(right, 1), at(apex, 1));
    b.triangle(at(left, -1), at(apex, -1), at(right, -1));
    // one wavelength: the light's spectrum is zero elsewhere but for the two samples around it
    Light ray;
    ray.name = "ray";
    ray.kind = LightKind::spot;
    const double incidence = std::asin(bk7(nm) / 2);
    const Vec3d normal{-std::cos(30 * degree), std::sin(30 * degree), 0};
    const Vec3d along{std::sin(30 * degree), std::cos(30 * degree), 0};
    ray.direction = normalize(normal * -std::cos(incidence) + along * std::sin(incidence));
    ray.position = Vec3d{-0.25, 0.4330127, 0} - ray.direction * 1.0;
    ray.cos_inner = ray.cos_outer = std::cos(1e-7);
    ray.photometric = 1e6;
    Spectrum line;
    const auto sample = static_cast<std::size_t>((nm - wavelength_min_nm) / sample_step_nm);
    line.samples[sample] = line.samples[sample + 1] = 1;
    b.scene.spectra.push_back(line);
    ray.spectrum = static_cast<std::uint32_t>(b.scene.spectra.size() - 1);
    b.scene.lights.push_back(ray);

    const auto tracer = std::move(TracerScene::make(b.scene).value());
    TracedHits hits;
    RayLog rays;
    double deviation = 0;
    for (std::uint64_t i = 0; i < 20'000 && deviation == 0; ++i) {
        hits.clear();
        rays.clear();
        tracer->trace(particles(1), {0, i, 1}, hits, &rays);
        const bool straight_through = rays.size() == 3 && hits.records.size() == 2;
        if (straight_through && std::abs(wavelength_nm(hits.records[0].wavelength) - nm) < 0.06)
            deviation = std::acos(dot(rays[0].direction, rays[2].direction)) / degree;
    }
    return deviation;
}

TEST(Glass, PrismOfBk7DeviatesByTheTable) {
    const std::pair<double, double> rows[] = {
        {400, 39.8895}, {486.13, 39.1381}, {587.56, 38.6467}, {656.27, 38.4291}, {700, 38.3188}};
    // a bin of 0.1 nm and the table of 5 nm leave less than 0.001 degrees
    for (const auto& [nm, degrees] : rows) EXPECT_NEAR(prism_deviation(nm), degrees, 1.5e-3) << nm;
}

TEST(Mirror, BoxOfMirrorsKeepsAllLightUntilTheSafetyBound) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.mirror(1), true);
    b.point_light({0.3, 0.4, 0.6}, 10);
    const Simulated s = simulate(b.scene, particles(64));
    EXPECT_EQ(s.solution.balance.bounce_limited, 64u);
    EXPECT_EQ(s.solution.balance.cut_off, s.solution.balance.emitted);
}

}  // namespace
}  // namespace lumenfarm::testing
