#include "cli/bench/bench_scene.h"

#include "common/spectrum/spectrum.h"

#include <cmath>
#include <string>

namespace lumenfarm {
namespace {

constexpr double albedo = 0.7;
constexpr double lamp_cd_m2 = 1000;

std::uint32_t add_corner(Scene& scene, double x, double y, double z) {
    scene.positions.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    return static_cast<std::uint32_t>(scene.positions.size() - 1);
}

void begin_surface(Scene& scene, const std::string& name) {
    scene.surfaces.push_back({name, name, static_cast<std::uint32_t>(scene.triangles.size()), 0, 0});
}

void add_triangle(Scene& scene, Triangle triangle) {
    scene.triangles.push_back(triangle);
    ++scene.surfaces.back().triangle_count;
}

/// Corners counter-clockwise seen from the front.
void add_quad(Scene& scene, const std::string& name, Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
    begin_surface(scene, name);
    const auto first = add_corner(scene, a.x, a.y, a.z);
    for (const Vec3d corner : {b, c, d}) add_corner(scene, corner.x, corner.y, corner.z);
    add_triangle(scene, {first, first + 1, first + 2});
    add_triangle(scene, {first, first + 2, first + 3});
}

void add_room(Scene& scene) {
    add_quad(scene, "floor", {0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0});
    add_quad(scene, "ceiling", {0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1});
    add_quad(scene, "left", {0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1});
    add_quad(scene, "right", {1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0});
    add_quad(scene, "back", {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    add_quad(scene, "front", {0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1});
    add_quad(scene, "lamp", {0.4, 0.999, 0.4}, {0.6, 0.999, 0.4}, {0.6, 0.999, 0.6}, {0.4, 0.999, 0.6});
}

/// Waves of two lengths over the whole floor, cells x cells squares.
void add_hills(Scene& scene, std::uint32_t cells) {
    begin_surface(scene, "hills");
    const auto first = static_cast<std::uint32_t>(scene.positions.size());
    for (std::uint32_t j = 0; j <= cells; ++j)
        for (std::uint32_t i = 0; i <= cells; ++i) {
            const double x = static_cast<double>(i) / cells;
            const double z = static_cast<double>(j) / cells;
            const double y = 0.25 + 0.1 * std::sin(25 * x) * std::cos(23 * z) + 0.01 * std::sin(170 * x + 140 * z);
            add_corner(scene, x, y, z);
        }
    for (std::uint32_t j = 0; j < cells; ++j)
        for (std::uint32_t i = 0; i < cells; ++i) {
            const std::uint32_t corner = first + j * (cells + 1) + i;
            add_triangle(scene, {corner, corner + cells + 1, corner + 1});
            add_triangle(scene, {corner + 1, corner + cells + 1, corner + cells + 2});
        }
}

}  // namespace

Scene make_bench_scene(std::uint64_t triangles) {
    Scene scene;
    scene.spectra = {constant_spectrum(albedo), constant_spectrum(1)};
    Material white;
    white.name = "white";
    white.diffuse.spectrum = 0;
    scene.materials.push_back(white);
    add_room(scene);
    Light lamp;
    lamp.name = "lamp";
    lamp.surface = static_cast<std::uint32_t>(scene.surfaces.size() - 1);
    lamp.photometric = lamp_cd_m2;
    lamp.spectrum = 1;
    scene.lights.push_back(lamp);
    add_hills(scene, static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(triangles) / 2))));
    return scene;
}

}  // namespace lumenfarm
