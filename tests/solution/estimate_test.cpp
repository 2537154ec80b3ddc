#include "common/solution/estimate.h"

#include "tests/solution/synthetic.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lumenfarm {
namespace {

JobSpec job(std::uint64_t particles) {
    JobSpec spec;
    spec.particles = particles;
    spec.texel_m = 0.25;
    return spec;
}

TEST(SurfaceEstimates, AreTicksTimesWattsOverArea) {
    LoadedRun run = test::empty_run(test::sheet_scene(), job(64'000));
    SurfaceBatches& sides = run.solution.surfaces[0];
    sides[0][3] = {7'000'000, 2'000'000, 100};
    sides[1][9] = {1'000'000, 500'000, 30};
    const double watts = watts_per_tick(run.emission, {64'000});
    const auto estimate = surface_estimates(run.scene, run.emission, run.solution).at(0);
    EXPECT_DOUBLE_EQ(estimate.total.area_m2, 4);
    EXPECT_DOUBLE_EQ(estimate.front.irradiance_w_m2, 7e6 * watts / 4);
    EXPECT_DOUBLE_EQ(estimate.front.illuminance_lx, 683 * 2e6 * watts / 4);
    EXPECT_DOUBLE_EQ(estimate.back.illuminance_lx, 683 * 5e5 * watts / 4);
    EXPECT_DOUBLE_EQ(estimate.total.illuminance_lx, 683 * 2.5e6 * watts / 4);
    EXPECT_EQ(estimate.total.hits, 130u);
}

TEST(SurfaceEstimates, ErrorFollowsFromTheSpreadOfTheBatches) {
    LoadedRun run = test::empty_run(test::sheet_scene(), job(64'000));
    for (std::size_t b = 0; b < limits::batches; ++b)
        run.solution.surfaces[0][0][b] = {1'000, b % 2 == 0 ? 900 : 1'100, 1};
    const auto estimate = surface_estimates(run.scene, run.emission, run.solution).at(0);
    EXPECT_NEAR(estimate.front.relative_error, 0.1 / std::sqrt(31.0), 1e-12);
    EXPECT_NEAR(estimate.front.standard_error_lx, estimate.front.relative_error * estimate.front.illuminance_lx, 1e-9);
    EXPECT_TRUE(std::isnan(estimate.back.relative_error));
}

TEST(SurfaceEstimates, BatchesThatEmittedNothingAreLeftOut) {
    LoadedRun run = test::empty_run(test::sheet_scene(), job(64'000));
    run.solution.balance.emitted = 0;
    for (std::size_t b = 0; b < limits::batches; ++b) {
        run.solution.balance.emitted_by_batch[b] = b < 4 ? 1'000'000 : 0;
        run.solution.balance.emitted += run.solution.balance.emitted_by_batch[b];
        if (b < 4) run.solution.surfaces[0][0][b] = {1'000, b % 2 == 0 ? 900 : 1'100, 1};
    }
    auto estimate = surface_estimates(run.scene, run.emission, run.solution).at(0);
    EXPECT_NEAR(estimate.front.relative_error, 0.1 / std::sqrt(3.0), 1e-12);
    run.solution.balance.emitted_by_batch = {1'000'000};
    run.solution.balance.emitted = 1'000'000;
    estimate = surface_estimates(run.scene, run.emission, run.solution).at(0);
    EXPECT_TRUE(std::isnan(estimate.front.relative_error)) << "one batch has no spread";
}

TEST(SurfaceEstimates, TheTruthLiesWithinTwoErrorsAsOftenAsStatisticsSay) {
    // 400 simulated solutions of Poisson batches: 95.5 % of a t-like variable within 2 errors; 4 sigma of the count
    std::mt19937_64 random(3);
    std::poisson_distribution<int> hits(50);
    LoadedRun run = test::empty_run(test::sheet_scene(), job(64'000));
    int covered = 0;
    for (int i = 0; i < 400; ++i) {
        for (BatchSums& batch : run.solution.surfaces[0][0]) {
            const int count = hits(random);
            batch = {count * 1'000, count * 1'000, static_cast<std::uint64_t>(count)};
        }
        const auto front = surface_estimates(run.scene, run.emission, run.solution).at(0).front;
        const double truth = 683 * watts_per_tick(run.emission, {64'000}) * 50 * 32 * 1'000 / 4;
        covered += std::abs(front.illuminance_lx - truth) < 2 * front.standard_error_lx ? 1 : 0;
    }
    EXPECT_NEAR(covered / 400.0, 0.945, 4 * std::sqrt(0.945 * 0.055 / 400));
}

TEST(SurfaceEstimates, AWhiteRoomHoldsItsClosedFormIlluminance) {
    // mean illuminance of a closed room: flux / (S (1 - albedo)) [oracles: enclosures]
    test::QuadScene quads;
    quads.room({2, 3, 4}, quads.lambert(0.5));
    quads.point_light({0.5, 1, 3}, 100, false);
    const LoadedRun run = test::traced_run(quads.scene, job(200'000));
    double lumens = 0, variance = 0, area = 0;
    for (const SurfaceEstimate& surface : surface_estimates(run.scene, run.emission, run.solution)) {
        lumens += surface.total.illuminance_lx * surface.total.area_m2;
        variance += std::pow(surface.total.standard_error_lx * surface.total.area_m2, 2);
        area += surface.total.area_m2;
        EXPECT_LT(surface.total.relative_error, 0.01);
        EXPECT_EQ(surface.back.hits, 0u);
    }
    const double truth = 4 * 3.14159265358979323846 * 100 / (area * 0.5);
    EXPECT_NEAR(lumens / area, truth, 4 * std::sqrt(variance) / area);
    EXPECT_LT(std::sqrt(variance) / lumens, 0.004);
}

TEST(TexelEstimate, VarianceIsTheSumOfSquares) {
    const TexelSums sums{400, 100, 320, 80, 2 * 100, 2};  // two hits of y = 160: (160 >> 4)^2 = 100
    const TexelEstimate estimate = texel_estimate(sums, 0.5, {2, 3});
    EXPECT_DOUBLE_EQ(estimate.xyz_lx.y, 320 * 3 / 0.5);
    EXPECT_DOUBLE_EQ(estimate.irradiance_w_m2, 400 * 2 / 0.5);
    EXPECT_DOUBLE_EQ(estimate.variance_lx2, 2 * std::pow(160 * 3 / 0.5, 2));
}

}  // namespace
}  // namespace lumenfarm
