#pragma once

#include "common/scene/scene.h"

#include <array>
#include <cstdint>
#include <vector>

/// Scattering by the mixtures of scene.h: Lambert, mirror, smooth dielectric.
namespace lumenfarm {

/// The materials of a scene with their spectra at hand.
class MaterialTable {
public:
    explicit MaterialTable(const Scene& scene) : scene_(&scene) {}

    /// Albedo of a slot at a wavelength bin, in [0, 1]. `uv` is asked only where the slot has a texture.
    template <class Uv>
    double albedo(const ColorSlot& slot, std::uint32_t bin, Uv&& uv) const {
        if (slot.spectrum == none) return 0;
        const double value = value_at(scene_->spectra[slot.spectrum], bin);
        return slot.texture == none ? value : value * texture_albedo(slot.texture, bin, uv());
    }
    const Material& material(std::uint32_t index) const { return scene_->materials[index]; }
    double refractive_index(const Material& material, std::uint32_t bin) const {
        return value_at(scene_->spectra[material.refractive_index], bin);
    }

private:
    /// Bilinear between the reflectances of four texels.
    double texture_albedo(std::uint32_t texture, std::uint32_t bin, Vec2f uv) const;

    const Scene* scene_;
};

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
    double relative_index = 1;   ///< refracted: n behind over n before
    double cos_transmitted = 0;
    double albedo() const { return first + second; }
};

/// Chooses glass or not by `chance` in [0, 1), which is then stretched to [0, 1) again for the next choice.
Lobes choose_lobes(const MaterialTable& materials, const Material& material, const Incidence& incidence, double& chance);

/// Direction after the lobe, unit. u, v in (0, 1) are used by lambert only.
Vec3d scattered_direction(const Lobes& lobes, Lobes::Kind kind, const Incidence& incidence, double u, double v);

}  // namespace lumenfarm
