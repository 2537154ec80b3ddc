#include "common/transport/emission.h"
#include "common/math/philox.h"
#include "common/math/sampling.h"
#include "common/spectrum/cie.h"
#include "common/transport/hit.h"
#include "tests/scenes/scene_builder.h"

#include <gtest/gtest.h>

#include <numeric>

namespace lumenfarm::testing {
namespace {

Emission of_shares(const std::vector<double>& fluxes) {
    Emission emission;
    for (const double flux : fluxes) {
        LightEmission light;
        light.flux_w = flux;
        emission.lights.push_back(light);
        emission.flux_w += flux;
    }
    for (LightEmission& light : emission.lights) light.share = light.flux_w / emission.flux_w;
    return emission;
}

TEST(Apportionment, GivesEveryParticleAndFollowsTheFlux) {
    const Emission emission = of_shares({5, 3, 2});
    const auto counts = apportion(emission, 1'000'000);
    EXPECT_EQ(counts, (std::vector<std::uint64_t>{500'000, 300'000, 200'000}));
    const auto odd = apportion(emission, 7);
    EXPECT_EQ(std::accumulate(odd.begin(), odd.end(), std::uint64_t{0}), 7u);
}

TEST(Apportionment, MoreParticlesNeverTakeOneFromALight) {
    const Emission emission = of_shares({1, 0.001, 3.7, 0.1, 12, 1e-7, 0.33});
    auto before = apportion(emission, 0);
    for (std::uint64_t n = 1; n < 3'000; ++n) {
        const auto now = apportion(emission, n);
        EXPECT_EQ(std::accumulate(now.begin(), now.end(), std::uint64_t{0}), n);
        for (std::size_t l = 0; l < now.size(); ++l) ASSERT_GE(now[l], before[l]) << n;
        before = now;
    }
}

TEST(Emission, FluxesFollowFromThePhotometry) {
    SceneBuilder b;
    const std::uint32_t lamp = b.surface("lamp", b.lambert(0));
    b.quad({0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {0, 0, 1});
    b.surface_light(lamp, 1000);
    b.point_light({0, 1, 0}, 10);
    const Emission emission = make_emission(b.scene).value();
    EXPECT_NEAR(emission.lights[0].flux_lm, M_PI * 1000 * 2, 1e-6);
    EXPECT_NEAR(emission.lights[1].flux_lm, 4 * M_PI * 10, 1e-9);
    // equal-energy light: 683 * 106.857 / 400 lm/W, the table's integral over 380..780 nm
    EXPECT_NEAR(emission.lights[1].flux_lm / emission.lights[1].flux_w, 683 * 106.857 / 400, 0.2);
}

TEST(Emission, ExpectedSpectrumIsTheLights) {
    SceneBuilder b;
    b.point_light({0, 1, 0}, 10);
    b.scene.spectra[b.scene.lights[0].spectrum] = illuminant_d65();
    const Emission emission = make_emission(b.scene).value();
    const LightEmission& light = emission.lights[0];
    double total = 0;
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) total += value_at(illuminant_d65(), bin);
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) {
        const double expected = value_at(illuminant_d65(), bin) / total;
        const double carried =
            (light.cumulative[bin + 1] - light.cumulative[bin]) * light.energy[bin] / light.mean_energy_ticks;
        ASSERT_NEAR(carried / expected, 1, 5e-5) << bin;
    }
    EXPECT_NEAR(light.mean_energy_ticks, limits::energy_ticks_nominal, 1);
    EXPECT_EQ(light.wavelength_guide.size(), wavelength_guide_size);
}

TEST(HitRecord, DirectionsSurviveThePackingWithinItsStep) {
    for (std::uint32_t i = 0; i < 10'000; ++i) {
        const auto r = philox(9, {i, 0, 0, 0});
        const Vec3d d = sample_uniform_zone(uniform(r[0]), uniform(r[1]), -1, 1);
        ASSERT_LT(length(decode_direction(encode_direction(d.as<float>())) - d), 7e-5);
    }
    for (const Vec3d axis : {Vec3d{1, 0, 0}, Vec3d{0, -1, 0}, Vec3d{0, 0, 1}, Vec3d{0, 0, -1}})
        EXPECT_LT(length(decode_direction(encode_direction(axis.as<float>())) - axis), 7e-5);
}

TEST(HitRecord, FlagsHoldBounceBatchAndSide) {
    HitRecord hit;
    hit.flags = hit_flags(5'000, 31, 1);
    EXPECT_EQ(hit.bounce(), 1023u);
    EXPECT_EQ(hit.batch(), 31u);
    EXPECT_EQ(hit.side(), 1u);
}

}  // namespace
}  // namespace lumenfarm::testing
