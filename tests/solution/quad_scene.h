#pragma once

#include "common/scene/scene.h"

#include <array>
#include <string>

/// Scenes of rectangles for tests, built in memory.
namespace lumenfarm::test {

class QuadScene {
public:
    /// A grey of the albedo, no mirror. Gives the material's number.
    std::uint32_t lambert(double albedo) {
        Material material;
        material.name = "grey " + std::to_string(albedo);
        material.diffuse = {spectrum(constant_spectrum(albedo)), none};
        return add(material);
    }
    std::uint32_t lambert(const Spectrum& albedo) {
        Material material;
        material.name = "paint";
        material.diffuse = {spectrum(albedo), none};
        return add(material);
    }
    std::uint32_t mirror(double reflectance) {
        Material material;
        material.name = "mirror";
        material.mirror = {spectrum(constant_spectrum(reflectance)), none};
        return add(material);
    }
    std::uint32_t pane(double index, bool thin) {
        Material material;
        material.name = "glass";
        material.dielectric = 1;
        material.transmission = {spectrum(constant_spectrum(1)), none};
        material.refractive_index = spectrum(constant_spectrum(index));
        material.thin = thin;
        return add(material);
    }
    /// Two triangles a, a + u, a + u + v, a + v; the front looks along u x v.
    std::uint32_t quad(const std::string& name, Vec3f a, Vec3f u, Vec3f v, std::uint32_t material) {
        const auto first = static_cast<std::uint32_t>(scene.positions.size());
        for (const Vec3f corner : {a, a + u, a + u + v, a + v}) scene.positions.push_back(corner);
        scene.surfaces.push_back({name, name, static_cast<std::uint32_t>(scene.triangles.size()), 2, material});
        scene.triangles.push_back({first, first + 1, first + 2});
        scene.triangles.push_back({first, first + 2, first + 3});
        return static_cast<std::uint32_t>(scene.surfaces.size() - 1);
    }
    void surface_light(std::uint32_t surface, double luminance, const Spectrum& light = constant_spectrum(1)) {
        Light lamp;
        lamp.name = "lamp " + std::to_string(scene.lights.size());
        lamp.surface = surface;
        lamp.photometric = luminance;
        lamp.spectrum = spectrum(light);
        scene.lights.push_back(lamp);
    }
    void point_light(Vec3d position, double candela, bool lambertian, Vec3d direction = {0, -1, 0}) {
        Light lamp;
        lamp.name = "lamp " + std::to_string(scene.lights.size());
        lamp.kind = LightKind::point;
        lamp.position = position;
        lamp.direction = direction;
        lamp.photometric = candela;
        lamp.lambertian = lambertian;
        lamp.spectrum = spectrum(constant_spectrum(1));
        scene.lights.push_back(lamp);
    }
    /// Six quads about [0, size] whose fronts look inwards.
    void room(Vec3f size, std::uint32_t material) {
        const Vec3f x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
        quad("floor", {}, z, x, material);
        quad("ceiling", y, x, z, material);
        quad("west", {}, y, z, material);
        quad("east", x, z, y, material);
        quad("north", {}, x, y, material);
        quad("south", z, y, x, material);
    }

    Scene scene;

private:
    std::uint32_t spectrum(const Spectrum& one) {
        scene.spectra.push_back(one);
        return static_cast<std::uint32_t>(scene.spectra.size() - 1);
    }
    std::uint32_t add(const Material& material) {
        scene.materials.push_back(material);
        return static_cast<std::uint32_t>(scene.materials.size() - 1);
    }
};

}  // namespace lumenfarm::test
