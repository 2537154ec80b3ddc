#pragma once

#include "common/math/sampling.h"
#include "common/scene/scene.h"
#include "common/transport/fresnel.h"

#include <array>
#include <cstdint>
#include <vector>

/// Scattering by the mixtures of scene.h: Lambert, mirror, smooth dielectric.
namespace lumenfarm {

/// The materials of a scene with their spectra at hand.
class MaterialTable {
public:
    explicit MaterialTable(const Scene& scene) : MaterialTable(scene, scene) {}
    /// Of a part of the scene: `geometry` has the triangles, `palette` the rest.
    MaterialTable(const Scene& palette, const Scene& geometry) : scene_(&palette), geometry_(&geometry) {}

    /// Albedo of a slot at a wavelength bin, in [0, 1]. `uv` is asked only where the slot has a texture.
    template <class Uv>
    double albedo(const ColorSlot& slot, std::uint32_t bin, Uv&& uv) const {
        if (slot.spectrum == none) return 0;
        const double value = value_at(scene_->spectra[slot.spectrum], bin);
        return slot.texture == none ? value : value * texture_albedo(slot.texture, bin, uv());
    }
    bool textured() const { return !scene_->textures.empty() && !geometry_->uvs.empty(); }
    /// Interpolated texture coordinates. REQUIRES: textured().
    Vec2f uv_at(std::uint32_t triangle, double b1, double b2) const;
    double refractive_index(const Material& material, std::uint32_t bin) const {
        return value_at(scene_->spectra[material.refractive_index], bin);
    }

private:
    /// Bilinear between the reflectances of four texels.
    double texture_albedo(std::uint32_t texture, std::uint32_t bin, Vec2f uv) const;

    const Scene* scene_;
    const Scene* geometry_;
};

/// The material of each surface of `geometry`, which may be a part of the scene.
std::vector<const Material*> materials_by_surface(const Scene& palette, const Scene& geometry);

/// What a particle meets: `normal` is the geometric one, on the side of incidence; cos_incident = -direction . normal.
struct Incidence {
    Vec3d direction;
    Vec3d normal;
    double cos_incident = 1;
    bool back = false;
    std::uint32_t bin = 0;
    Vec2f uv;
};

/// The two ways to go on from one component of the mixture; the rest, 1 - first - second, is absorbed.
struct Lobes {
    enum class Kind : std::uint8_t { lambert, mirror, straight, refracted };
    Kind first_kind = Kind::lambert;
    Kind second_kind = Kind::mirror;
    double first = 0;
    double second = 0;
    double relative_index = 1;  ///< refracted: n behind over n before
    double cos_transmitted = 0;
    double albedo() const { return first + second; }
};

inline Lobes glass_lobes(const MaterialTable& materials, const Material& material, const Incidence& incidence) {
    const double index = materials.refractive_index(material, incidence.bin);
    const double tint = materials.albedo(material.transmission, incidence.bin, [&] { return incidence.uv; });
    Lobes lobes;
    lobes.first_kind = Lobes::Kind::mirror;
    if (material.thin) {
        lobes.second_kind = Lobes::Kind::straight;
        lobes.first = sheet_reflectance(fresnel(incidence.cos_incident, index).reflectance);
    } else {
        lobes.second_kind = Lobes::Kind::refracted;
        lobes.relative_index = incidence.back ? 1 / index : index;
        const FresnelSplit split = fresnel(incidence.cos_incident, lobes.relative_index);
        lobes.first = split.reflectance;
        lobes.cos_transmitted = split.cos_transmitted;
    }
    lobes.second = (1 - lobes.first) * tint;
    return lobes;
}

/// Chooses glass or not by `chance` in [0, 1), which is then stretched to [0, 1) again for the next choice.
inline Lobes choose_lobes(const MaterialTable& materials, const Material& material, const Incidence& incidence,
                          double& chance) {
    const double glass = static_cast<double>(material.dielectric);
    if (chance < glass) {
        chance /= glass;
        return glass_lobes(materials, material, incidence);
    }
    if (glass > 0) chance = (chance - glass) / (1 - glass);
    const auto uv = [&] { return incidence.uv; };
    Lobes lobes;
    lobes.first = materials.albedo(material.diffuse, incidence.bin, uv);
    lobes.second = materials.albedo(material.mirror, incidence.bin, uv);
    return lobes;
}

/// Direction after a lobe that leaves no choice, unit. REQUIRES: kind is not lambert.
inline Vec3d specular_direction(const Lobes& lobes, Lobes::Kind kind, const Incidence& in) {
    switch (kind) {
        case Lobes::Kind::mirror: return normalize(in.direction + in.normal * (2 * in.cos_incident));
        case Lobes::Kind::refracted: {
            const double eta = 1 / lobes.relative_index;
            return normalize(in.direction * eta + in.normal * (eta * in.cos_incident - lobes.cos_transmitted));
        }
        case Lobes::Kind::straight:
        case Lobes::Kind::lambert: break;
    }
    return in.direction;
}

}  // namespace lumenfarm
