#pragma once

#include "cli/import/import.h"
#include "common/scene/scene.h"
#include "common/spectrum/spectrum.h"

#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

/// Collects what the readers of the formats find, keeps the rules of a compiled scene, and gathers warnings.
namespace lumenfarm::import {

/// A material as a format gives it, and the light that surfaces of it emit.
struct ImportedMaterial {
    std::uint32_t index = 0;                 ///< into Scene::materials
    double luminance = 0;                    ///< [cd/m2]; 0 emits nothing
    std::uint32_t emission_spectrum = none;  ///< REQUIRED where luminance > 0
};

/// Triangles of one object with one material, in world space.
struct MeshPart {
    std::string object;               ///< what the user calls it
    std::string part;                 ///< what tells this part from others of the object; empty when it is the only one
    std::vector<Vec3d> positions;     ///< [m]
    std::vector<Vec2f> uvs;           ///< empty, or one for each position
    std::vector<Triangle> triangles;  ///< front counter-clockwise
    ImportedMaterial material;
};

class SceneBuilder {
public:
    explicit SceneBuilder(std::filesystem::path file) : file_(std::move(file)) {}

    const std::filesystem::path& file() const { return file_; }
    /// "'box.obj': sentence"
    Error refuse(const std::string& sentence) const;
    /// Listed once, however often it is said.
    void warn(const std::string& sentence);

    std::uint32_t add_spectrum(const Spectrum& spectrum);  ///< equal spectra share an index
    std::uint32_t add_reflectance(Vec3d linear_srgb);
    std::uint32_t add_light_spectrum(Vec3d linear_srgb);
    std::uint32_t add_texture(Texture texture);
    std::uint32_t add_material(Material material);
    Material& material(std::uint32_t index) { return scene_.materials[index]; }

    /// Triangles without area are dropped and counted. Errors: indices or coordinates out of range, too many.
    Result<void> add_mesh(MeshPart part);
    void add_light(Light light) { scene_.lights.push_back(std::move(light)); }
    void add_camera(Camera camera);

    const Scene& scene() const { return scene_; }
    /// Adds the default light if asked for, and validates.
    Result<ImportedScene> finish(const ImportOptions& options);

private:
    std::string unique_name(const std::string& wanted);
    /// Appends the vertex when it is new to this part.
    std::uint32_t place_vertex(const MeshPart& part, std::uint32_t vertex, std::vector<std::uint32_t>& placed);
    Result<void> check_mesh(const MeshPart& part) const;

    std::filesystem::path file_;
    Scene scene_;
    std::vector<std::string> warnings_;
    std::unordered_set<std::string> said_;
    std::unordered_set<std::string> names_;
    std::unordered_map<std::string, std::uint64_t> next_suffix_;
    std::unordered_map<std::string, std::uint32_t> spectrum_by_bytes_;
    std::uint64_t dropped_triangles_ = 0;
    std::uint64_t unlisted_warnings_ = 0;
};

}  // namespace lumenfarm::import
