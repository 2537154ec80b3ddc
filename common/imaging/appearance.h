#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "common/transport/bsdf.h"
#include "common/transport/emission.h"

#include <cstdint>
#include <vector>

/// Colours of a scene's materials and lights for pictures.
namespace lumenfarm {

class Appearance {
public:
    /// REQUIRES: validate(scene) succeeds; `scene` outlives this.
    Appearance(const Scene& scene, const Emission& emission);

    /// Albedo of a slot as linear sRGB under D65. An approximation of its spectrum, exact for greys.
    Vec3d albedo(const ColorSlot& slot, Vec2f uv) const;
    /// Radiance that a side of a surface emits: linear sRGB scaled to luminance [cd/m2]; 0 where it is no light.
    Vec3d emitted(std::uint32_t surface, std::uint32_t side) const;
    /// Linear sRGB of all lights together; luminance 1.
    Vec3d light_white() const { return light_white_; }
    const MaterialTable& materials() const { return materials_; }
    const Material& material_of(std::uint32_t triangle) const {
        return scene_.materials[scene_.surfaces[surface_of_triangle_[triangle]].material];
    }
    std::uint32_t surface_of(std::uint32_t triangle) const { return surface_of_triangle_[triangle]; }
    /// Texture coordinates at a point of a triangle; (0, 0) where the scene has none.
    Vec2f uv_at(std::uint32_t triangle, double b1, double b2) const;

private:
    Vec3d integrate(const ColorSlot& slot, Vec2f uv) const;

    const Scene& scene_;
    MaterialTable materials_;
    std::vector<std::uint32_t> surface_of_triangle_;
    struct Weight {
        std::uint32_t bin;
        Vec3d rgb;
    };
    std::vector<Weight> weights_;  ///< of wavelengths under D65; sum to (1, 1, 1)
    std::vector<Vec3d> plain_;     ///< by spectrum: albedo without texture
    std::vector<Vec3d> emitted_;   ///< by surface: from the front
    Vec3d light_white_{1, 1, 1};
};

}  // namespace lumenfarm
