#pragma once

#include "cli/import/scene_builder.h"

#include <tiny_obj_loader.h>

#include <map>
#include <string>
#include <utility>

namespace lumenfarm::import {

/// MTL materials to Lambert, mirror, smooth glass and mixtures of them, as docs/scenes.md says; each approximation is a
/// warning that names the material. Errors: bad_input with the material's name.
class MtlMaterials {
public:
    MtlMaterials(SceneBuilder& builder, double ke_scale) : builder_(builder), ke_scale_(ke_scale) {}

    /// The first of a name counts. `folder_file`: the MTL file, whose folder holds the pictures.
    void know(const tinyobj::material_t& material, const std::filesystem::path& folder_file);
    bool knows(const std::string& name) const { return given_.count(name) > 0; }
    bool depends_on_shape(const std::string& name) const;
    /// Unknown names become Lambert reflectors of reflectance 0.8, with a warning.
    Result<ImportedMaterial> compile(const std::string& name, bool closed);

private:
    struct Given {
        tinyobj::material_t material;
        std::filesystem::path file;
    };
    Result<ImportedMaterial> compile_new(const Given& given, const std::string& name, bool closed);
    Result<void> check(const tinyobj::material_t& m, const std::string& who) const;
    void set_reflection(const tinyobj::material_t& m, Material& out, const std::string& who);
    void set_glass(const tinyobj::material_t& m, Material& out, const std::string& who, bool closed);
    Result<void> set_picture(const Given& given, Material& out, const std::string& who);
    void warn_of_rest(const tinyobj::material_t& m, const std::string& who);

    SceneBuilder& builder_;
    double ke_scale_;
    std::map<std::string, Given> given_;
    std::map<std::pair<std::string, bool>, ImportedMaterial> compiled_;
    std::map<std::string, std::uint32_t> texture_by_path_;
};

}  // namespace lumenfarm::import
