#include "common/imaging/render.h"

#include "common/imaging/tone_map.h"
#include "common/spectrum/cie.h"
#include "tests/solution/synthetic.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lumenfarm {
namespace {

constexpr double pi = 3.14159265358979323846;

JobSpec job(std::uint64_t particles, double texel_m, std::uint64_t keep_hits = 0) {
    JobSpec spec;
    spec.particles = particles;
    spec.texel_m = texel_m;
    spec.keep_hits = keep_hits;
    return spec;
}

/// The same light on every texel: ticks in proportion to the texel's area.
void set_uniform(LoadedRun& run, double ticks_per_m2) {
    for (std::uint64_t i = 0; i < run.solution.texels.size(); ++i) {
        const auto place = run.layout.place_of(i);
        const double n = run.layout.rows(place.triangle);
        const auto ticks = std::llround(ticks_per_m2 * triangle_area_m2(run.scene, place.triangle) / (n * n));
        run.solution.texels[i] = {ticks, ticks, ticks, ticks, 100, 10};
    }
}

double luminance(const Pixel& pixel) {
    const Vec3d rgb = pixel.radiance.as<double>();
    return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z;
}

Camera looking(Vec3d from, Vec3d forward, double fov = 20) {
    const Vec3d up = std::abs(forward.y) > 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0};
    return {"test", from, forward, up, fov, 1};
}

Picture rendered(const LoadedRun& run, const Camera& camera, RenderOptions options) {
    const auto tracer = TracerScene::make(run.scene);
    EXPECT_TRUE(tracer);
    const auto picture = render(run, **tracer, camera, options);
    EXPECT_TRUE(picture) << picture.error().sentence;
    return *picture;
}

TEST(Render, ADiffuseSurfaceShowsIlluminanceTimesAlbedoOverPi) {
    LoadedRun run = test::empty_run(test::sheet_scene(), job(64'000, 0.1));
    set_uniform(run, 1e8);
    const double lux = 1e8 * tick_value(run.emission, run.solution).lumens;
    const Picture picture = rendered(run, looking({0, 3, 0}, {0, -1, 0}), {16, 16, 2, 1, Estimator::automatic});
    for (const Pixel& pixel : picture.pixels) {
        EXPECT_NEAR(luminance(pixel) / (lux * 0.5 / pi), 1, 2e-3);
        EXPECT_NEAR(static_cast<double>(pixel.illuminance_lx) / lux, 1, 1e-3);
        EXPECT_GT(pixel.hit_count, 0);
        EXPECT_LT(pixel.relative_error, 1);
    }
}

TEST(Render, AMirrorAndAPaneShowTheSheetBehindWithTheirShare) {
    test::QuadScene quads;
    quads.quad("sheet", {-5, 0, -5}, {0, 0, 10}, {10, 0, 0}, quads.lambert(0.5));
    quads.quad("mirror", {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}, quads.mirror(0.8));  // looks down
    quads.quad("pane", {3, 2, -1}, {2, 0, 0}, {0, 0, 2}, quads.pane(1.5, true));
    quads.point_light({0, 100, 0}, 1'000, false);
    LoadedRun run = test::empty_run(quads.scene, job(64'000, 0.5));
    set_uniform(run, 1e8);
    const double direct = 1e8 * tick_value(run.emission, run.solution).lumens * 0.5 / pi;
    const RenderOptions options{4, 4, 1, 1, Estimator::automatic};
    for (const Pixel& pixel : rendered(run, looking({0, 1, 0}, {0, 1, 0}, 5), options).pixels)
        EXPECT_NEAR(luminance(pixel) / direct, 0.8, 2e-3);
    // a pane of n = 1.5 at normal incidence, all orders: transmittance 0.92308 [oracles: parallel slab]
    for (const Pixel& pixel : rendered(run, looking({4, 3, 0}, {0, -1, 0}, 1), options).pixels)
        EXPECT_NEAR(luminance(pixel) / direct, 0.92308, 3e-3);
}

TEST(Render, SolidGlassLosesLightOnlyByReflection) {
    // a slab seen straight: both faces followed with all orders give (1 - R) / (1 + R), and n^2 cancels
    test::QuadScene quads;
    quads.quad("sheet", {-5, 0, -5}, {0, 0, 10}, {10, 0, 0}, quads.lambert(0.5));
    const auto glass = quads.pane(1.5, false);
    quads.quad("slab top", {-1, 2, -1}, {0, 0, 2}, {2, 0, 0}, glass);
    quads.quad("slab bottom", {-1, 1.5f, -1}, {2, 0, 0}, {0, 0, 2}, glass);
    quads.point_light({0, 100, 0}, 1'000, false);
    LoadedRun run = test::empty_run(quads.scene, job(64'000, 0.5));
    set_uniform(run, 1e8);
    const double direct = 1e8 * tick_value(run.emission, run.solution).lumens * 0.5 / pi;
    for (const Pixel& pixel :
         rendered(run, looking({0, 3, 0}, {0, -1, 0}, 1), {4, 4, 1, 1, Estimator::automatic}).pixels)
        EXPECT_NEAR(luminance(pixel) / direct, 0.92308, 6e-3);
}

TEST(Render, ALampShowsItsLuminanceOnItsFrontOnly) {
    test::QuadScene quads;
    quads.surface_light(quads.quad("lamp", {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, quads.lambert(0)), 1'234);
    const LoadedRun run = test::empty_run(quads.scene, job(64'000, 0.5));
    const RenderOptions options{2, 2, 1, 1, Estimator::automatic};
    for (const Pixel& pixel : rendered(run, looking({0, 3, 0}, {0, -1, 0}), options).pixels)
        EXPECT_NEAR(luminance(pixel), 1'234, 1);
    for (const Pixel& pixel : rendered(run, looking({0, -3, 0}, {0, 1, 0}), options).pixels)
        EXPECT_EQ(luminance(pixel), 0);
}

TEST(Render, ThreadsChangeNoBitAndBothEstimatorsAgree) {
    test::QuadScene quads;
    quads.room({2, 2, 2}, quads.lambert(0.5));
    quads.point_light({1, 1.5, 1}, 100, false);
    const LoadedRun run = test::traced_run(quads.scene, job(100'000, 0.1, 200'000));
    const Camera camera = looking({1, 1, 1.8}, {0, -0.2, -1}, 60);
    const auto picture = [&](std::uint32_t threads, Estimator estimator) {
        return rendered(run, camera, {24, 18, 1, threads, estimator});
    };
    const Picture one = picture(1, Estimator::texels), three = picture(3, Estimator::texels);
    const Picture near = picture(2, Estimator::automatic);
    double fitted = 0, nearest = 0;
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
        EXPECT_EQ(one.pixels[i].radiance, three.pixels[i].radiance);
        fitted += luminance(one.pixels[i]);
        nearest += luminance(near.pixels[i]);
    }
    // the nearest hits are an average over a disc, here a tenth of the room wide: edges gain a few per cent
    EXPECT_NEAR(nearest / fitted, 1, 0.05);
    EXPECT_NE(near.pixels[0].radiance, one.pixels[0].radiance) << "kept hits are used when there are any";
}

TEST(Render, NearestHitsSeeTheColourOfTheLightThatCame) {
    // light of one narrow band on a paint that reflects that band only: an sRGB product cannot know, hits do
    test::QuadScene quads;
    Spectrum band, paint;
    for (std::size_t i = 38; i <= 40; ++i) band.samples[i] = paint.samples[i] = 1;  // 570 to 580 nm
    quads.quad("sheet", {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, quads.lambert(paint));
    quads.point_light({0, 100, 0}, 1'000, false);
    quads.scene.spectra.back() = band;
    LoadedRun run = test::empty_run(quads.scene, job(64'000, 0.1, 2'000));
    auto records = test::uniform_records(1, run.scene, 2'000);
    for (HitRecord& record : records) record.wavelength = 1'950;  // 575 nm
    test::fill(run, records);
    std::int64_t y = 0;
    for (const TexelSums& texel : run.solution.texels) y += texel.y;
    const double lux = static_cast<double>(y) * tick_value(run.emission, run.solution).lumens / 4;
    const Picture picture = rendered(run, looking({0, 3, 0}, {0, -1, 0}), {20, 20, 1, 1, Estimator::nearest_hits});
    double mean = 0;
    for (const Pixel& pixel : picture.pixels) mean += luminance(pixel) / 400;
    EXPECT_NEAR(mean / (lux / pi), 1, 0.1);
}

TEST(Render, RefusesViewsThatAreNone) {
    const LoadedRun run = test::empty_run(test::sheet_scene(), job(64'000, 0.5));
    const auto tracer = TracerScene::make(run.scene);
    const Camera good = looking({0, 3, 0}, {0, -1, 0});
    const auto refused = [&](Camera camera, RenderOptions options) { return !render(run, **tracer, camera, options); };
    EXPECT_TRUE(refused(good, {0, 10}));
    EXPECT_TRUE(refused(good, {10, 20'000}));
    EXPECT_TRUE(refused(good, {10, 10, 0}));
    Camera bad = good;
    bad.up = {0, 1, 0};
    EXPECT_TRUE(refused(bad, {10, 10}));
    bad = good;
    bad.vertical_fov_degrees = 180;
    EXPECT_TRUE(refused(bad, {10, 10}));
    bad = good;
    bad.position.x = std::nan("");
    EXPECT_TRUE(refused(bad, {10, 10}));
}

}  // namespace
}  // namespace lumenfarm
