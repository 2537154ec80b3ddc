#pragma once

#include "common/scene/scene.h"

#include <cmath>
#include <functional>
#include <string>

/// Scenes for tests, written as code: rooms, boxes, spheres, plates.
namespace lumenfarm::testing {

class SceneBuilder {
public:
    Scene scene;

    std::uint32_t spectrum(double value) {
        scene.spectra.push_back(constant_spectrum(value));
        return static_cast<std::uint32_t>(scene.spectra.size() - 1);
    }
    std::uint32_t add(Material material) {
        scene.materials.push_back(std::move(material));
        return static_cast<std::uint32_t>(scene.materials.size() - 1);
    }
    std::uint32_t lambert(double albedo) {
        Material m;
        m.name = "lambert";
        m.diffuse.spectrum = spectrum(albedo);
        return add(m);
    }
    std::uint32_t mirror(double reflectance) {
        Material m;
        m.name = "mirror";
        m.mirror.spectrum = spectrum(reflectance);
        return add(m);
    }
    std::uint32_t glass(double index, bool thin = false) {
        Material m;
        m.name = "glass";
        m.dielectric = 1;
        m.thin = thin;
        m.transmission.spectrum = spectrum(1);
        m.refractive_index = spectrum(index);
        return add(m);
    }

    /// Starts a surface; triangles added from now on belong to it.
    std::uint32_t surface(const std::string& name, std::uint32_t material) {
        scene.surfaces.push_back({name, name, static_cast<std::uint32_t>(scene.triangles.size()), 0, material});
        return static_cast<std::uint32_t>(scene.surfaces.size() - 1);
    }
    void triangle(Vec3f a, Vec3f b, Vec3f c) {
        const auto n = static_cast<std::uint32_t>(scene.positions.size());
        scene.positions.insert(scene.positions.end(), {a, b, c});
        scene.triangles.push_back({n, n + 1, n + 2});
        ++scene.surfaces.back().triangle_count;
    }
    /// Corners counter-clockwise seen from the front.
    void quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
        triangle(a, b, c);
        triangle(a, c, d);
    }
    /// The six walls of a box, each its own surface, fronts inwards (a room) or outwards (a block).
    void box(const std::string& name, Vec3f low, Vec3f high, std::uint32_t material, bool inwards) {
        const auto corner = [&](int x, int y, int z) {
            return Vec3f{x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z};
        };
        const auto wall = [&](const char* side, Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
            surface(name + " " + side, material);
            if (inwards)
                quad(a, b, c, d);
            else
                quad(d, c, b, a);
        };
        wall("floor", corner(0, 0, 0), corner(0, 0, 1), corner(1, 0, 1), corner(1, 0, 0));
        wall("ceiling", corner(0, 1, 0), corner(1, 1, 0), corner(1, 1, 1), corner(0, 1, 1));
        wall("left", corner(0, 0, 0), corner(0, 1, 0), corner(0, 1, 1), corner(0, 0, 1));
        wall("right", corner(1, 0, 0), corner(1, 0, 1), corner(1, 1, 1), corner(1, 1, 0));
        wall("back", corner(0, 0, 0), corner(1, 0, 0), corner(1, 1, 0), corner(0, 1, 0));
        wall("front", corner(0, 0, 1), corner(0, 1, 1), corner(1, 1, 1), corner(1, 0, 1));
    }
    /// A sphere of 2 * slices * slices triangles or so, one surface.
    void sphere(const std::string& name, Vec3f centre, float radius, std::uint32_t slices, std::uint32_t material,
                bool inwards = false) {
        surface(name, material);
        const auto at = [&](std::uint32_t i, std::uint32_t j) {
            const double theta = M_PI * i / slices;
            const double phi = 2 * M_PI * (j % (2 * slices)) / (2 * slices);
            const double ring = i == 0 || i == slices ? 0 : std::sin(theta);
            return centre + Vec3d{ring * std::cos(phi), std::cos(theta), ring * std::sin(phi)}.as<float>() * radius;
        };
        const auto face = [&](Vec3f a, Vec3f b, Vec3f c) {
            if (inwards)
                triangle(a, c, b);
            else
                triangle(a, b, c);
        };
        for (std::uint32_t i = 0; i < slices; ++i)
            for (std::uint32_t j = 0; j < 2 * slices; ++j) {
                if (i > 0) face(at(i, j), at(i, j + 1), at(i + 1, j + 1));
                if (i > 0 && i + 1 < slices) face(at(i, j), at(i + 1, j + 1), at(i + 1, j));
                if (i == 0) face(at(0, j), at(1, j + 1), at(1, j));
            }
    }
    /// A height field over [0, 1]^2 at `base`, (cells * cells * 2) triangles.
    void terrain(const std::string& name, std::uint32_t cells, float base, std::uint32_t material) {
        surface(name, material);
        const auto first = static_cast<std::uint32_t>(scene.positions.size());
        for (std::uint32_t j = 0; j <= cells; ++j)
            for (std::uint32_t i = 0; i <= cells; ++i) {
                const double x = static_cast<double>(i) / cells;
                const double z = static_cast<double>(j) / cells;
                const double h = base + 0.1 * std::sin(25 * x) * std::cos(23 * z) + 0.01 * std::sin(170 * x + 140 * z);
                scene.positions.push_back({static_cast<float>(x), static_cast<float>(h), static_cast<float>(z)});
            }
        for (std::uint32_t j = 0; j < cells; ++j)
            for (std::uint32_t i = 0; i < cells; ++i) {
                const std::uint32_t a = first + j * (cells + 1) + i;
                scene.triangles.push_back({a, a + cells + 1, a + 1});
                scene.triangles.push_back({a + 1, a + cells + 1, a + cells + 2});
                scene.surfaces.back().triangle_count += 2;
            }
    }
    void point_light(Vec3d position, double candela) {
        Light light;
        light.name = "point";
        light.kind = LightKind::point;
        light.position = position;
        light.photometric = candela;
        light.spectrum = spectrum(1);
        scene.lights.push_back(light);
    }
    void surface_light(std::uint32_t surface, double cd_m2) {
        Light light;
        light.name = scene.surfaces[surface].name;
        light.kind = LightKind::surface;
        light.surface = surface;
        light.photometric = cd_m2;
        light.spectrum = spectrum(1);
        scene.lights.push_back(light);
    }
};

/// A closed room with a block, a mirror plate, a glass ball, and two lights: every kind of surface of this program.
inline Scene mixed_room() {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.7), true);
    b.box("block", {0.1f, 0, 0.15f}, {0.35f, 0.4f, 0.4f}, b.lambert(0.5), false);
    b.surface("plate", b.mirror(0.9));
    b.quad({0.55f, 0.1f, 0.05f}, {0.95f, 0.1f, 0.05f}, {0.95f, 0.6f, 0.05f}, {0.55f, 0.6f, 0.05f});
    b.sphere("ball", {0.7f, 0.2f, 0.6f}, 0.15f, 24, b.glass(1.5));
    const std::uint32_t lamp = b.surface("lamp", b.lambert(0.5));
    b.quad({0.4f, 0.99f, 0.4f}, {0.6f, 0.99f, 0.4f}, {0.6f, 0.99f, 0.6f}, {0.4f, 0.99f, 0.6f});
    b.surface_light(lamp, 1000);
    b.point_light({0.2, 0.8, 0.8}, 50);
    return b.scene;
}

/// Hills of so many cells along a side, of two triangles each, in a room under a lamp.
inline Scene hills_room(std::uint32_t cells) {
    SceneBuilder b;
    b.box("room", {0, 0, 0}, {1, 1, 1}, b.lambert(0.7), true);
    b.terrain("hills", cells, 0.25f, b.lambert(0.6));
    const std::uint32_t lamp = b.surface("lamp", b.lambert(0.5));
    b.quad({0.4f, 0.99f, 0.4f}, {0.6f, 0.99f, 0.4f}, {0.6f, 0.99f, 0.6f}, {0.4f, 0.99f, 0.6f});
    b.surface_light(lamp, 1000);
    return b.scene;
}

}  // namespace lumenfarm::testing
