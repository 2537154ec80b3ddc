#include "cli/import/gltf_textures.h"

#include "cli/import/gltf_value.h"

#include <cmath>

namespace lumenfarm::import {
namespace {

constexpr double transform_max = 1e5;

Wrap wrap_of(int gltf) {
    if (gltf == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp;
    return gltf == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirrored_repeat : Wrap::repeat;
}

/// Two numbers; `otherwise` when missing or of another shape.
Vec2f pair_member(const tinygltf::Value& value, const char* key, Vec2f otherwise) {
    const tinygltf::Value* found = member(value, key);
    const auto list = found == nullptr ? std::nullopt : numbers(*found);
    if (!list || list->size() != 2) return otherwise;
    return {static_cast<float>((*list)[0]), static_cast<float>((*list)[1])};
}

}  // namespace

Vec2f TextureUse::apply(Vec2f uv) const {
    const double c = std::cos(rotation), s = std::sin(rotation);
    const double u = double{uv.x} * scale.x, v = double{uv.y} * scale.y;
    return {static_cast<float>(offset.x + c * u + s * v), static_cast<float>(offset.y - s * u + c * v)};
}

Result<const tinygltf::Texture*> GltfTextures::find(int index) const {
    if (index < 0 || static_cast<std::size_t>(index) >= model_.textures.size())
        return builder_.refuse("texture " + std::to_string(index) + " does not exist; there are " +
                               std::to_string(model_.textures.size()));
    return &model_.textures[static_cast<std::size_t>(index)];
}

Result<Picture> GltfTextures::picture(const tinygltf::Texture& texture) const {
    if (texture.source < 0 || static_cast<std::size_t>(texture.source) >= model_.images.size())
        return builder_.refuse("a texture refers to image " + std::to_string(texture.source) + " of " +
                               std::to_string(model_.images.size()));
    const tinygltf::Image& image = model_.images[static_cast<std::size_t>(texture.source)];
    const std::string name =
        image.uri.empty() ? gltf_name("image", static_cast<std::size_t>(texture.source), image.name) : image.uri;
    std::span<const std::byte> bytes = std::as_bytes(std::span(image.image));
    if (image.bufferView >= 0) {
        const auto view = view_bytes(model_, image.bufferView, builder_);
        if (!view) return view.error();
        bytes = *view;
    } else if (bytes.empty()) {
        return builder_.refuse("the picture '" + name + "' does not exist as a file, or is empty");
    }
    auto picture = decode_picture(bytes, name);
    if (!picture) return builder_.refuse(picture.error().sentence);
    return picture;
}

Result<std::uint32_t> GltfTextures::texture(int index) {
    if (const auto known = compiled_.find(index); known != compiled_.end()) return known->second;
    const auto found = find(index);
    if (!found) return found.error();
    const auto decoded = picture(**found);
    if (!decoded) return decoded.error();
    Texture texture = to_texture(*decoded);
    const int sampler = (*found)->sampler;
    if (sampler >= 0 && static_cast<std::size_t>(sampler) < model_.samplers.size()) {
        texture.wrap_u = wrap_of(model_.samplers[static_cast<std::size_t>(sampler)].wrapS);
        texture.wrap_v = wrap_of(model_.samplers[static_cast<std::size_t>(sampler)].wrapT);
    }
    return compiled_[index] = builder_.add_texture(std::move(texture));
}

Result<Vec3d> GltfTextures::mean(int index) {
    const auto found = find(index);
    if (!found) return found.error();
    const auto decoded = picture(**found);
    if (!decoded) return decoded.error();
    return mean_colour(*decoded);
}

Result<TextureUse> GltfTextures::use(const tinygltf::TextureInfo& where) const {
    TextureUse use;
    use.tex_coord = where.texCoord;
    const auto extension = where.extensions.find("KHR_texture_transform");
    if (extension == where.extensions.end()) return use;
    const tinygltf::Value& transform = extension->second;
    const auto rotation = number_member(transform, "rotation", 0, -transform_max, transform_max);
    if (!rotation) return builder_.refuse("KHR_texture_transform: " + rotation.error().sentence);
    use.rotation = *rotation;
    use.offset = pair_member(transform, "offset", {0, 0});
    use.scale = pair_member(transform, "scale", {1, 1});
    const auto set = number_member(transform, "texCoord", use.tex_coord, 0, 7);
    if (!set) return builder_.refuse("KHR_texture_transform: " + set.error().sentence);
    use.tex_coord = static_cast<int>(*set);
    return use;
}

}  // namespace lumenfarm::import
