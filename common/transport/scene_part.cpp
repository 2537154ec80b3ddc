#include "common/transport/scene_part.h"

#include <unordered_map>

namespace lumenfarm {
namespace {

constexpr double margin = 0x1p-20;  ///< of the scene's half extent; distances in double are good to far less

/// Copies triangles with their corners, each corner once.
class Geometry {
public:
    Geometry(const Scene& whole, ScenePart& part) : whole_(whole), part_(part) {}

    void add(std::uint32_t triangle) {
        const Triangle& corners = whole_.triangles[triangle];
        part_.scene.triangles.push_back({corner(corners[0]), corner(corners[1]), corner(corners[2])});
        part_.numbers.push_back(triangle);
    }

private:
    std::uint32_t corner(std::uint32_t whole) {
        const auto [at, added] = corners_.emplace(whole, static_cast<std::uint32_t>(part_.scene.positions.size()));
        if (added) {
            part_.scene.positions.push_back(whole_.positions[whole]);
            if (!whole_.uvs.empty()) part_.scene.uvs.push_back(whole_.uvs[whole]);
        }
        return at->second;
    }

    const Scene& whole_;
    ScenePart& part_;
    std::unordered_map<std::uint32_t, std::uint32_t> corners_;  ///< of the whole scene, to those of the part
};

}  // namespace

ScenePart part_of(const Scene& scene, std::span<const std::uint32_t> triangles) {
    ScenePart part;
    Geometry geometry(scene, part);
    auto next = triangles.begin();
    for (const Surface& surface : scene.surfaces) {
        Surface here{{}, {}, static_cast<std::uint32_t>(part.scene.triangles.size()), 0, surface.material};
        for (; next != triangles.end() && *next < surface.first_triangle + surface.triangle_count; ++next) {
            geometry.add(*next);
            ++here.triangle_count;
        }
        if (here.triangle_count > 0) part.scene.surfaces.push_back(here);
    }
    return part;
}

ScenePart palette_of(const Scene& scene) {
    std::vector<bool> emits(scene.surfaces.size());
    for (const Light& light : scene.lights)
        if (light.kind == LightKind::surface) emits[light.surface] = true;
    ScenePart palette;
    palette.scene.materials = scene.materials;
    palette.scene.spectra = scene.spectra;
    palette.scene.textures = scene.textures;
    palette.scene.lights = scene.lights;
    Geometry geometry(scene, palette);
    for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
        Surface here = scene.surfaces[s];
        if (!emits[s]) here.triangle_count = 1;
        for (std::uint32_t t = 0; t < here.triangle_count; ++t) geometry.add(here.first_triangle + t);
        here.first_triangle = static_cast<std::uint32_t>(palette.scene.triangles.size()) - here.triangle_count;
        palette.scene.surfaces.push_back(std::move(here));
    }
    return palette;
}

double part_margin_m(const SceneExtent& extent) { return margin * extent.half_m; }

}  // namespace lumenfarm
