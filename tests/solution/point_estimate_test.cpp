#include "common/solution/disc_area.h"
#include "common/solution/nearest_hits.h"
#include "common/solution/point_light.h"
#include "common/solution/texel_fit.h"
#include "tests/solution/synthetic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace lumenfarm {
namespace {

constexpr double pi = 3.14159265358979323846;

JobSpec job(double texel_m, std::uint64_t keep_hits = 0) {
    JobSpec spec;
    spec.particles = 64'000;
    spec.texel_m = texel_m;
    spec.keep_hits = keep_hits;
    return spec;
}

/// A run with the estimators over it.
struct Estimators {
    explicit Estimators(const LoadedRun& run)
        : index(run.scene),
          tick(tick_value(run.emission, run.solution)),
          texels(run.scene, index, run.layout, run.solution, tick),
          hits(run.scene, index, run.solution, tick) {}
    TriangleIndex index;
    TickValue tick;
    TexelFit texels;
    NearestHits hits;
};

/// Gives each texel of the front the value of a field [lx] at its centroid.
void set_field(LoadedRun& run, const std::function<double(Vec3d)>& field) {
    const double lumens = tick_value(run.emission, run.solution).lumens;
    for (std::uint64_t i = 0; i < run.solution.texels.size(); ++i) {
        const auto place = run.layout.place_of(i);
        const double n = run.layout.rows(place.triangle);
        const Vec2f b = TexelLayout::cell_centroid(place.cell, run.layout.rows(place.triangle));
        const Vec3d at =
            point_on_triangle(run.scene, place.triangle, static_cast<double>(b.x), static_cast<double>(b.y), 0)
                .position;
        const double area = triangle_area_m2(run.scene, place.triangle) / (n * n);
        if (place.side == 0) run.solution.texels[i] = {0, 0, std::llround(field(at) * area / lumens), 0, 1, 1};
    }
}

SurfacePoint point_at(const LoadedRun& run, const TriangleIndex& index, Vec3d position) {
    const auto found = find_surface_points(run.scene, index, position, Vec3d{0, 1, 0}, 1e-3);
    return found.at(0);
}

TEST(TexelFit, AFieldOfTheFittedDegreeIsMetExactlyEvenAtCornersAndSeams) {
    LoadedRun run = test::empty_run(test::sheet_scene(), job(0.08));
    const auto linear = [](Vec3d p) { return 5e6 + 1e6 * p.x - 2e6 * p.z; };
    const auto quadratic = [&](Vec3d p) { return linear(p) + 7e5 * p.x * p.x - 9e5 * p.x * p.z; };
    for (const Vec3d at : {Vec3d{0, 0, 0}, Vec3d{0.3, 0, -0.3}, Vec3d{-1, 0, 1}, Vec3d{1, 0, 1}, Vec3d{0.97, 0, 0.2}}) {
        set_field(run, linear);
        const Estimators over(run);
        const SurfacePoint point = point_at(run, over.index, at);
        EXPECT_NEAR(over.texels.at(point, 0.2, FitDegree::linear).xyz_lx.y, linear(at), 1e-4 * linear(at));
        set_field(run, quadratic);
        EXPECT_NEAR(over.texels.at(point, 0.25, FitDegree::quadratic).xyz_lx.y, quadratic(at), 1e-3 * quadratic(at));
    }
}

TEST(TexelFit, TheOtherSideAndTheFarFaceOfASheetStayOut) {
    test::QuadScene quads;
    const auto grey = quads.lambert(0.5);
    quads.quad("top", {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, grey);
    quads.quad("bottom", {-1, -0.01f, -1}, {2, 0, 0}, {0, 0, 2}, grey);  // looks down, 1 cm below
    quads.point_light({0, 50, 0}, 1'000, false);
    LoadedRun run = test::empty_run(quads.scene, job(0.1));
    set_field(run, [](Vec3d p) { return p.y < -0.005 ? 9e6 : 1e6; });
    const Estimators over(run);
    const SurfacePoint top = point_at(run, over.index, {0.2, 0, 0.1});
    EXPECT_NEAR(over.texels.at(top, 0.3, FitDegree::linear).xyz_lx.y, 1e6, 1e3);
    SurfacePoint under = top;
    under.side = 1;
    under.normal = -top.normal;
    EXPECT_EQ(over.texels.at(under, 0.3, FitDegree::linear).hits, 0u);
}

TEST(TexelFit, StatesTheErrorThatItHas) {
    // uniform Poisson light, 200 seeds: the spread of the estimates is the stated error, and their mean the truth
    const double truth_hits = 4'000;
    double sum = 0, squares = 0, stated = 0;
    LoadedRun run = test::empty_run(test::sheet_scene(), job(0.1));
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        test::fill(run, test::uniform_records(seed, run.scene, 4'000));
        const Estimators over(run);
        const auto estimate = over.texels.at(point_at(run, over.index, {0.1, 0, 0.3}), 0.4, FitDegree::quadratic);
        sum += estimate.xyz_lx.y;
        squares += estimate.xyz_lx.y * estimate.xyz_lx.y;
        stated += estimate.standard_error_lx;
    }
    const double mean = sum / 200, spread = std::sqrt(squares / 200 - mean * mean);
    const TexelSums all = [&] {
        TexelSums total;
        for (const TexelSums& texel : run.solution.texels) total += texel;
        return total;
    }();
    const double truth =
        static_cast<double>(all.y) * tick_value(run.emission, run.solution).lumens / 4 * truth_hits / 4'000;
    EXPECT_NEAR(mean, truth, 4 * spread / std::sqrt(200.0) + 0.02 * truth);  // the last run's own total varies 1.6 %
    EXPECT_NEAR(spread / (stated / 200), 1, 0.2);                            // 4 / sqrt(2 * 200)
}

TEST(DiscArea, KnowsCutsOfCirclesAndTriangles) {
    test::QuadScene quads;
    quads.quad("square", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, quads.lambert(0.5));
    const auto both = [&](Vec3d centre, double radius) {
        return area_within_m2(quads.scene, 0, centre, radius) + area_within_m2(quads.scene, 1, centre, radius);
    };
    EXPECT_NEAR(both({0.5, 0.5, 0}, 0.3), pi * 0.09, 1e-12);
    EXPECT_NEAR(both({0, 0, 0}, 0.3), pi * 0.09 / 4, 1e-12);
    EXPECT_NEAR(both({0.5, 0, 0}, 0.3), pi * 0.09 / 2, 1e-12);
    EXPECT_NEAR(both({0.5, 0.5, 0}, 10), 1, 1e-12);
    EXPECT_NEAR(both({0.5, 0.5, 0.4}, 0.5), pi * 0.09, 1e-12);
    EXPECT_EQ(both({3, 3, 0}, 0.5), 0);
    EXPECT_EQ(both({0.5, 0.5, 2}, 0.5), 0);
    const double slice = 0.25 * std::acos(0.4) - 0.2 * std::sqrt(0.25 - 0.04);  // beyond a chord 0.2 from the centre
    EXPECT_NEAR(both({0.5, -0.2, 0}, 0.5), slice, 1e-12);
}

/// Mean over seeds of kNN estimates of a uniform field, over its truth.
double mean_over_truth(Vec3d at, std::uint32_t k, int seeds, double& error) {
    LoadedRun run = test::empty_run(test::sheet_scene(), job(0.5, 1'000));
    double sum = 0, squares = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        test::fill(run, test::uniform_records(static_cast<std::uint64_t>(seed) + 1'000, run.scene, 1'000));
        const Estimators over(run);
        double total = 0;
        for (const KeptHit& hit : run.solution.kept) total += hit.energy;
        const auto estimate = over.hits.estimate(over.hits.around(point_at(run, over.index, at), k, 10));
        const double ratio = estimate.irradiance_w_m2 / (total * over.tick.watts / 4);
        sum += ratio;
        squares += ratio * ratio;
    }
    error = std::sqrt((squares / seeds - sum * sum / seeds / seeds) / seeds);
    return sum / seeds;
}

TEST(NearestHits, UniformHitsGiveNoBiasInTheMiddleAtAnEdgeAndInACorner) {
    // k / (pi r^2) would be 11 % too high at k = 10; an edge or a corner without its area a half or three quarters low
    for (const Vec3d at : {Vec3d{0.1, 0, -0.2}, Vec3d{1, 0, 0.1}, Vec3d{-1, 0, -1}}) {
        double error = 0;
        const double mean = mean_over_truth(at, 10, 600, error);
        EXPECT_LT(error, 0.02);
        EXPECT_NEAR(mean, 1, 4 * error) << at.x;
    }
}

TEST(NearestHits, AKeptSampleSpeaksForAllHits) {
    LoadedRun run = test::empty_run(test::sheet_scene(), job(0.5, 5'000));
    test::fill(run, test::uniform_records(5, run.scene, 50'000));
    const Estimators over(run);
    const auto estimate = over.hits.estimate(over.hits.around(point_at(run, over.index, {0, 0, 0}), 2'000, 10));
    std::int64_t y = 0;
    for (const TexelSums& texel : run.solution.texels) y += texel.y;
    const double truth = static_cast<double>(y) * over.tick.lumens / 4;
    EXPECT_NEAR(estimate.xyz_lx.y, truth, 4 * estimate.standard_error_lx);
    EXPECT_LT(estimate.standard_error_lx, 0.05 * truth);
    EXPECT_EQ(estimate.hits, 1'999u);
}

TEST(NearestHits, AgreesWithASearchThroughAllHits) {
    LoadedRun run = test::empty_run(test::sheet_scene(), job(0.5, 3'000));
    test::fill(run, test::uniform_records(6, run.scene, 3'000));
    const Estimators over(run);
    const SurfacePoint point = point_at(run, over.index, {0.7, 0, 0.2});
    std::vector<double> distances;
    for (const KeptHit& hit : run.solution.kept) {
        const Vec3d at = point_on_triangle(run.scene, hit.record.triangle, (hit.record.b1 + 0.5) / 65'536,
                                           (hit.record.b2 + 0.5) / 65'536, 0)
                             .position;
        distances.push_back(length(at - point.position));
    }
    std::sort(distances.begin(), distances.end());
    for (const std::uint32_t k : {2u, 17u, 500u}) {
        const auto near = over.hits.around(point, k, 10);
        EXPECT_TRUE(near.bounded_by_hit);
        EXPECT_NEAR(near.radius_m, distances[k - 1], 1e-6);
        EXPECT_EQ(near.hits.size(), k - 1);
    }
    const auto few = over.hits.around(point, 3'000, 0.1);
    EXPECT_FALSE(few.bounded_by_hit);
    EXPECT_NEAR(few.area_m2, pi * 0.01, 1e-9);
}

TEST(FindSurfacePoints, TakesTheSideThatFacesTheNormal) {
    const LoadedRun run = test::empty_run(test::sheet_scene(), job(0.5));
    const TriangleIndex index(run.scene);
    const auto find = [&](Vec3d at, std::optional<Vec3d> normal) {
        return find_surface_points(run.scene, index, at, normal, 1e-3);
    };
    EXPECT_EQ(find({0, 0.0005, 0}, Vec3d{0, 1, 0}).at(0).side, 0u);
    EXPECT_EQ(find({0, 0.0005, 0}, Vec3d{0, -1, 0}).at(0).side, 1u);
    EXPECT_EQ(find({0, 0, 0}, std::nullopt).size(), 2u);
    EXPECT_TRUE(find({0, 0.002, 0}, Vec3d{0, 1, 0}).empty());
    EXPECT_TRUE(find({0, 0, 0}, Vec3d{1, 0, 0}).empty());
    EXPECT_TRUE(find({1.01, 0, 0}, Vec3d{0, 1, 0}).empty());
}

}  // namespace
}  // namespace lumenfarm
