#include "cli/import/scene_builder.h"

#include "cli/import/default_light.h"
#include "common/scene/scene_file.h"
#include "common/scene/text.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace lumenfarm::import {
namespace {

bool storable(Vec3d p) {
    const auto inside = [](double c) { return std::abs(c) <= limits::coordinate_max_m; };
    return inside(p.x) && inside(p.y) && inside(p.z);
}

bool has_texture(const Material& m) {
    return m.diffuse.texture != none || m.mirror.texture != none || m.transmission.texture != none;
}

/// Area of the triangle as the compiled scene will have it, from float positions.
bool has_area(const MeshPart& part, const Triangle& t) {
    const auto at = [&](std::uint32_t v) { return part.positions[v].as<float>().as<double>(); };
    return length(cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]))) > 0;
}

}  // namespace

Error SceneBuilder::refuse(const std::string& sentence) const {
    return bad_input("'" + clean_name(file_.string()) + "': " + clean_name(sentence));
}

void SceneBuilder::warn(const std::string& sentence) {
    if (said_.size() >= limits::warnings_max) {
        ++unlisted_warnings_;
    } else if (said_.insert(sentence).second) {
        warnings_.push_back(clean_name(sentence));
    }
}

std::uint32_t SceneBuilder::add_spectrum(const Spectrum& spectrum) {
    std::string bytes(sizeof spectrum, '\0');
    std::memcpy(bytes.data(), &spectrum, sizeof spectrum);
    const auto [place, is_new] =
        spectrum_by_bytes_.emplace(std::move(bytes), static_cast<std::uint32_t>(scene_.spectra.size()));
    if (is_new) scene_.spectra.push_back(spectrum);
    return place->second;
}

std::uint32_t SceneBuilder::add_reflectance(Vec3d linear_srgb) {
    return add_spectrum(reflectance_spectrum(linear_srgb));
}

std::uint32_t SceneBuilder::add_light_spectrum(Vec3d linear_srgb) { return add_spectrum(light_spectrum(linear_srgb)); }

std::uint32_t SceneBuilder::add_texture(Texture texture) {
    scene_.textures.push_back(std::move(texture));
    return static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

std::uint32_t SceneBuilder::add_material(Material material) {
    material.name = clean_name(material.name);
    scene_.materials.push_back(std::move(material));
    return static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

void SceneBuilder::add_camera(Camera camera) {
    camera.name = clean_name(camera.name);
    scene_.cameras.push_back(std::move(camera));
}

std::string SceneBuilder::unique_name(const std::string& wanted) {
    // Cut first, so that the suffix is kept.
    const std::string base = clean_name(wanted.empty() ? "surface" : wanted.substr(0, limits::name_bytes_max - 24));
    std::string name = base;
    auto& suffix = next_suffix_[base];
    while (!names_.insert(name).second) name = base + "#" + std::to_string(++suffix + 1);
    return name;
}

std::uint32_t SceneBuilder::place_vertex(const MeshPart& part, std::uint32_t vertex,
                                         std::vector<std::uint32_t>& placed) {
    if (placed[vertex] == none) {
        placed[vertex] = static_cast<std::uint32_t>(scene_.positions.size());
        scene_.positions.push_back(part.positions[vertex].as<float>());
        scene_.uvs.push_back(part.uvs.empty() ? Vec2f{} : part.uvs[vertex]);
    }
    return placed[vertex];
}

Result<void> SceneBuilder::check_mesh(const MeshPart& part) const {
    const std::string who = "object '" + part.object + "'";
    for (const Triangle& triangle : part.triangles) {
        for (const std::uint32_t vertex : triangle) {
            if (vertex >= part.positions.size())
                return refuse(who + " refers to vertex " + std::to_string(vertex) + " of " +
                              std::to_string(part.positions.size()));
            const Vec3d p = part.positions[vertex];
            if (!storable(p))
                return refuse(who + " has vertex " + std::to_string(vertex) + " at (" + std::to_string(p.x) + ", " +
                              std::to_string(p.y) + ", " + std::to_string(p.z) +
                              ") m; coordinates must be finite and within 1e7 m");
        }
    }
    if (scene_.triangles.size() + part.triangles.size() > limits::triangles_max ||
        scene_.positions.size() + part.positions.size() > limits::vertices_max)
        return refuse(who + " brings the scene above " + std::to_string(limits::triangles_max) + " triangles or " +
                      std::to_string(limits::vertices_max) + " vertices");
    return {};
}

Result<void> SceneBuilder::add_mesh(MeshPart part) {
    if (auto checked = check_mesh(part); !checked) return checked;
    if (!has_texture(scene_.materials[part.material.index])) part.uvs.clear();
    const auto first = static_cast<std::uint32_t>(scene_.triangles.size());
    std::vector<std::uint32_t> placed(part.positions.size(), none);
    for (const Triangle& t : part.triangles) {
        if (has_area(part, t)) {
            Triangle corners{};
            for (std::size_t i = 0; i < 3; ++i) corners[i] = place_vertex(part, t[i], placed);
            scene_.triangles.push_back(corners);
        } else {
            ++dropped_triangles_;
        }
    }
    const auto count = static_cast<std::uint32_t>(scene_.triangles.size()) - first;
    if (count == 0) {
        warn("object '" + part.object + "' has no triangle with an area and is left out");
        return {};
    }
    const std::string name = unique_name(part.part.empty() ? part.object : part.object + "/" + part.part);
    scene_.surfaces.push_back({name, clean_name(part.object), first, count, part.material.index});
    if (part.material.luminance > 0) {
        Light light;
        light.name = name;
        light.kind = LightKind::surface;
        light.spectrum = part.material.emission_spectrum;
        light.photometric = part.material.luminance;
        light.surface = static_cast<std::uint32_t>(scene_.surfaces.size() - 1);
        scene_.lights.push_back(light);
    }
    return {};
}

Result<ImportedScene> SceneBuilder::finish(const ImportOptions& options) {
    if (dropped_triangles_ > 0) warn(std::to_string(dropped_triangles_) + " triangles without area were dropped");
    if (scene_.triangles.empty()) return refuse("the file has no triangle with an area");
    if (options.default_light) {
        if (auto added = add_mesh(default_light(*this)); !added) return added.error();
    }
    if (std::none_of(scene_.materials.begin(), scene_.materials.end(), has_texture)) scene_.uvs.clear();
    if (unlisted_warnings_ > 0)
        warnings_.push_back(std::to_string(unlisted_warnings_) + " more warnings are not listed");
    if (auto valid = validate(scene_); !valid) return refuse(valid.error().sentence);
    return ImportedScene{std::move(scene_), std::move(warnings_)};
}

}  // namespace lumenfarm::import
