#pragma once

#include "cli/import/gltf_spectra.h"
#include "cli/import/gltf_textures.h"

#include <map>
#include <optional>
#include <utility>

namespace lumenfarm::import {

/// glTF materials to Lambert, mirror, smooth glass and mixtures of them, as docs/scenes.md says; each approximation is
/// a warning that names the material. Errors: bad_input with the material's name.
class GltfMaterials {
public:
    GltfMaterials(const tinygltf::Model& model, SceneBuilder& builder);

    /// `material` as a primitive has it, -1 for none. `closed`: the primitive bounds a volume, which decides whether
    /// glass without a stated thickness is solid.
    Result<ImportedMaterial> compile(int material, bool closed);
    /// True when `closed` decides what the material is.
    bool depends_on_shape(int material) const;
    /// How its base colour picture is laid on; nothing when it has none.
    Result<std::optional<TextureUse>> texture_use(int material) const;

private:
    struct Factors;
    Result<Factors> read_factors(const tinygltf::Material& material, const std::string& who) const;
    Result<ImportedMaterial> compile_new(const tinygltf::Material& material, const std::string& who, bool closed);
    ImportedMaterial compile_default();
    void set_reflection(const Factors& f, Material& out, const std::string& who);
    void set_glass(const Factors& f, Material& out, const std::string& who, bool closed);
    void set_given(const GivenSpectra& given, Material& out);
    Result<void> set_emission(const tinygltf::Material& material, const Factors& f, const GivenSpectra& given,
                              ImportedMaterial& out, const std::string& who);
    void warn_of_rest(const tinygltf::Material& material, const std::string& who);
    Error refuse(const std::string& who, const Error& error) const;

    const tinygltf::Model& model_;
    SceneBuilder& builder_;
    GltfTextures textures_;
    std::map<std::pair<int, bool>, ImportedMaterial> compiled_;
};

}  // namespace lumenfarm::import
