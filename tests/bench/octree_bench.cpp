#include "common/octree/octree.h"

#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>
#include <time.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

/// Builds our octree and Embree's hierarchy over the same million triangles in one run, on equal threads, and prints
/// the ratio of the times. The goal is a ratio of at most 2.
namespace lumenfarm {
namespace {

/// A closed, bumpy surface like a scanned model: rows x columns quads over a sphere, two triangles each.
Scene bumpy_sphere(std::uint32_t rows, std::uint32_t columns) {
    Scene scene;
    const double pi = std::acos(-1.0);
    for (std::uint32_t i = 0; i <= rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const double theta = pi * (0.001 + 0.998 * i / rows), phi = 2 * pi * j / columns;
            const double r = 1 + 0.1 * std::sin(5 * theta) * std::cos(7 * phi) + 0.01 * std::sin(90 * phi + 60 * theta);
            scene.positions.push_back(
                Vec3d{r * std::sin(theta) * std::cos(phi), r * std::cos(theta), r * std::sin(theta) * std::sin(phi)}
                    .as<float>());
        }
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const std::uint32_t a = i * columns + j, b = i * columns + (j + 1) % columns;
            scene.triangles.push_back({a, b, a + columns});
            scene.triangles.push_back({b, b + columns, a + columns});
        }
    return scene;
}

/// A height field over a square grid, as terrain and tessellated floors are.
Scene terrain(std::uint32_t side, double relief_m) {
    Scene scene;
    for (std::uint32_t i = 0; i <= side; ++i)
        for (std::uint32_t j = 0; j <= side; ++j) {
            const double x = 10.0 * i / side, z = 10.0 * j / side;
            scene.positions.push_back(
                Vec3d{x, relief_m * (std::sin(2 * x) * std::cos(3 * z) + 0.07 * std::sin(40 * x + 31 * z)), z}
                    .as<float>());
        }
    for (std::uint32_t i = 0; i < side; ++i)
        for (std::uint32_t j = 0; j < side; ++j) {
            const std::uint32_t a = i * (side + 1) + j;
            scene.triangles.push_back({a, a + 1, a + side + 1});
            scene.triangles.push_back({a + 1, a + side + 2, a + side + 1});
        }
    return scene;
}

/// Small triangles anywhere in a cube, as leaves and grass are.
Scene soup(std::uint32_t triangles) {
    Scene scene;
    std::minstd_rand random(1);
    const auto uniform = [&random] { return static_cast<double>(random()) / 2147483648.0; };
    for (std::uint32_t i = 0; i < triangles; ++i) {
        const Vec3d at{uniform(), uniform(), uniform()};
        for (int k = 0; k < 3; ++k)
            scene.positions.push_back(
                (at + Vec3d{uniform() - 0.5, uniform() - 0.5, uniform() - 0.5} * 0.01).as<float>());
        scene.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return scene;
}

struct EmbreeBuild {
    EmbreeBuild(const Scene& scene, std::uint32_t threads)
        : device(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())), hierarchy(rtcNewScene(device)) {
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        void* vertices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f),
                                                 scene.positions.size());
        std::memcpy(vertices, scene.positions.data(), scene.positions.size() * sizeof(Vec3f));
        void* indices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Triangle),
                                                scene.triangles.size());
        std::memcpy(indices, scene.triangles.data(), scene.triangles.size() * sizeof(Triangle));
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(hierarchy, mesh);
        rtcReleaseGeometry(mesh);
        rtcSetSceneBuildQuality(hierarchy, RTC_BUILD_QUALITY_MEDIUM);
    }
    EmbreeBuild(const EmbreeBuild&) = delete;
    EmbreeBuild& operator=(const EmbreeBuild&) = delete;
    ~EmbreeBuild() {
        rtcReleaseScene(hierarchy);
        rtcReleaseDevice(device);
    }
    RTCDevice device;
    RTCScene hierarchy;
};

/// Wall time, and the CPU time of all threads: the second is what a busy machine leaves comparable.
struct Seconds {
    double wall = 0, cpu = 0;
};

double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Work>
Seconds seconds_of(Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    const double cpu = cpu_seconds();
    work();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), cpu_seconds() - cpu};
}

/// One iteration builds both; the reported time is ours.
void build(benchmark::State& state, Scene (*make)(), std::uint32_t threads) {
    const Scene scene = make();
    OctreeOptions options;
    options.threads = threads;
    Seconds ours, embrees;
    double nodes = 0, references = 0;
    for ([[maybe_unused]] auto iteration : state) {
        const EmbreeBuild embree(scene, threads);
        const Seconds committed = seconds_of([&] { rtcCommitScene(embree.hierarchy); });
        const Seconds grown = seconds_of([&] {
            const Octree octree = Octree::make(scene, options);
            nodes = static_cast<double>(octree.nodes().size());
            references = static_cast<double>(octree.items().size());
        });
        embrees = {embrees.wall + committed.wall, embrees.cpu + committed.cpu};
        ours = {ours.wall + grown.wall, ours.cpu + grown.cpu};
        state.SetIterationTime(grown.wall);
    }
    const auto iterations = static_cast<double>(state.iterations());
    state.counters["triangles"] = static_cast<double>(scene.triangles.size());
    state.counters["nodes"] = nodes;
    state.counters["references"] = references;
    state.counters["octree_s"] = ours.wall / iterations;
    state.counters["embree_s"] = embrees.wall / iterations;
    state.counters["ratio"] = ours.wall / embrees.wall;
    state.counters["cpu_ratio"] = ours.cpu / embrees.cpu;
}

Scene million_sphere() { return bumpy_sphere(500, 1000); }
Scene million_terrain() { return terrain(707, 0.3); }
Scene million_floor() { return terrain(707, 0); }
Scene million_soup() { return soup(1'000'000); }

void register_builds() {
    for (const std::uint32_t threads : {1u, 2u})
        for (const auto& [name, make] :
             {std::pair{"bumpy_sphere", &million_sphere}, std::pair{"terrain", &million_terrain},
              std::pair{"floor", &million_floor}, std::pair{"soup", &million_soup}})
            benchmark::RegisterBenchmark((std::string(name) + "/threads:" + std::to_string(threads)).c_str(), build,
                                         make, threads)
                ->UseManualTime()
                ->Unit(benchmark::kMillisecond)
                ->Iterations(3);
}

}  // namespace
}  // namespace lumenfarm

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    lumenfarm::register_builds();
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
