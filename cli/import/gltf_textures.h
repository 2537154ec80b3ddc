#pragma once

#include "cli/import/gltf_file.h"
#include "cli/import/image.h"

#include <map>

namespace lumenfarm::import {

/// How a primitive's texture coordinates become those of its picture. [KHR_texture_transform]
struct TextureUse {
    int tex_coord = 0;
    Vec2f offset;
    Vec2f scale{1, 1};
    double rotation = 0;  ///< radians, counter-clockwise in the picture
    Vec2f apply(Vec2f uv) const;
};

/// The pictures and samplers of a glTF file. Errors: bad_input (indices, missing or damaged pictures).
class GltfTextures {
public:
    GltfTextures(const tinygltf::Model& model, SceneBuilder& builder) : model_(model), builder_(builder) {}

    /// Index into Scene::textures.
    Result<std::uint32_t> texture(int index);
    Result<Vec3d> mean(int index);
    Result<TextureUse> use(const tinygltf::TextureInfo& where) const;

private:
    Result<const tinygltf::Texture*> find(int index) const;
    Result<Picture> picture(const tinygltf::Texture& texture) const;

    const tinygltf::Model& model_;
    SceneBuilder& builder_;
    std::map<int, std::uint32_t> compiled_;
};

}  // namespace lumenfarm::import
