#include "cli/import/gltf_file.h"

#include "cli/import/gltf_guard.h"
#include "cli/import/resource.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <algorithm>
#include <array>
#include <exception>
#include <limits>

namespace lumenfarm::import {
namespace {

constexpr std::array supported_extensions{
    "KHR_lights_punctual",    "KHR_materials_emissive_strength", "KHR_materials_ior",
    "KHR_materials_specular", "KHR_materials_transmission",      "KHR_materials_volume",
    "KHR_mesh_quantization",  "KHR_materials_dispersion",        "KHR_texture_transform"};

/// The library asks for files through this; the first refusal is kept for the user.
struct Files {
    std::filesystem::path scene;
    Error refusal{ErrorCode::bad_input, {}};

    Result<std::filesystem::path> resolve(const std::string& name) {
        auto path = resource_path(scene, name);
        if (!path && refusal.sentence.empty()) refusal = path.error();
        return path;
    }
};

bool file_exists(const std::string& name, void* user) {
    const auto path = static_cast<Files*>(user)->resolve(name);
    std::error_code ignored;
    return path && std::filesystem::is_regular_file(*path, ignored);
}

std::string keep_name(const std::string& name, void*) { return name; }

bool read_whole_file(std::vector<unsigned char>* out, std::string*, const std::string& name, void* user) {
    Files& files = *static_cast<Files*>(user);
    const auto path = files.resolve(name);
    if (!path) return false;
    const auto bytes = read_file(*path, limits::import_file_bytes_max);
    if (!bytes) {
        files.refusal = bytes.error();
        return false;
    }
    const auto* begin = reinterpret_cast<const unsigned char*>(bytes->data());
    out->assign(begin, begin + bytes->size());
    return true;
}

/// Keeps a picture's own bytes. Those in buffer views are left where they are: the library has not checked the view.
bool keep_image(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes, int size,
                void*) {
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    image->as_is = true;
    return true;
}

std::string first_line(const std::string& text) {
    const std::string line = text.substr(0, text.find('\n'));
    return line.substr(0, 300);
}

Result<void> parse(SceneBuilder& builder, std::span<const std::byte> bytes, bool binary, tinygltf::Model& model) {
    Files files{builder.file()};
    tinygltf::TinyGLTF loader;
    loader.SetFsCallbacks({file_exists, keep_name, read_whole_file, nullptr, &files});
    loader.SetImageLoader(keep_image, nullptr);
    std::string errors, ignored;
    bool good = false;
    const auto size = static_cast<unsigned>(bytes.size());
    try {
        if (binary) {
            good = loader.LoadBinaryFromMemory(&model, &errors, &ignored,
                                               reinterpret_cast<const unsigned char*>(bytes.data()), size);
        } else {
            good = loader.LoadASCIIFromString(&model, &errors, &ignored, reinterpret_cast<const char*>(bytes.data()),
                                              size, "");
        }
    } catch (const std::exception& error) {
        errors = error.what();
        good = false;
    }
    if (!files.refusal.sentence.empty()) return files.refusal;
    // The library goes on after some errors and leaves things out; nothing is left out silently here.
    if (!good || !errors.empty())
        return builder.refuse("not a valid glTF file: " +
                              (errors.empty() ? "it cannot be parsed" : first_line(errors)));
    return {};
}

Result<void> check_extensions(const SceneBuilder& builder, const tinygltf::Model& model) {
    for (const std::string& name : model.extensionsRequired)
        if (std::find(supported_extensions.begin(), supported_extensions.end(), name) == supported_extensions.end())
            return builder.refuse("the file requires the glTF extension '" + name + "', which is not supported");
    return {};
}

}  // namespace

std::string gltf_name(const char* kind, std::size_t index, const std::string& name) {
    const std::string text = std::string(kind) + " " + std::to_string(index);
    return name.empty() ? text : text + " ('" + name + "')";
}

Result<tinygltf::Model> load_gltf(SceneBuilder& builder) {
    const auto bytes = read_file(builder.file(), limits::import_file_bytes_max);
    if (!bytes) return bytes.error();
    if (bytes->empty()) return builder.refuse("the file is empty");
    if (bytes->size() > std::numeric_limits<std::uint32_t>::max())
        return builder.refuse("the file has " + std::to_string(bytes->size()) + " bytes; glTF files end at 4 GiB");
    const bool binary = bytes->size() >= 4 && std::memcmp(bytes->data(), "glTF", 4) == 0;
    if (!binary && (builder.file().extension() == ".glb" || builder.file().extension() == ".GLB"))
        return builder.refuse("this is not a GLB: its first bytes are not 'glTF'");
    std::string_view json(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    if (binary) {
        const auto chunk = glb_json(*bytes);
        if (!chunk) return builder.refuse(chunk.error().sentence);
        json = *chunk;
    }
    if (auto shape = check_json_shape(json); !shape) return builder.refuse(shape.error().sentence);
    tinygltf::Model model;
    if (auto parsed = parse(builder, *bytes, binary, model); !parsed) return parsed.error();
    if (model.asset.version.substr(0, 2) != "2.")
        return builder.refuse("the file has glTF version '" + model.asset.version + "'; version 2 is read");
    if (auto known = check_extensions(builder, model); !known) return known.error();
    return model;
}

Result<std::span<const std::byte>> view_bytes(const tinygltf::Model& model, int view, const SceneBuilder& builder) {
    if (view < 0 || static_cast<std::size_t>(view) >= model.bufferViews.size())
        return builder.refuse("buffer view " + std::to_string(view) + " does not exist; there are " +
                              std::to_string(model.bufferViews.size()));
    const tinygltf::BufferView& v = model.bufferViews[static_cast<std::size_t>(view)];
    if (v.buffer < 0 || static_cast<std::size_t>(v.buffer) >= model.buffers.size())
        return builder.refuse("buffer view " + std::to_string(view) + " refers to buffer " + std::to_string(v.buffer) +
                              " of " + std::to_string(model.buffers.size()));
    const auto bytes = std::as_bytes(std::span(model.buffers[static_cast<std::size_t>(v.buffer)].data));
    if (v.byteOffset > bytes.size() || v.byteLength > bytes.size() - v.byteOffset)
        return builder.refuse("buffer view " + std::to_string(view) + " covers " + std::to_string(v.byteLength) +
                              " bytes from " + std::to_string(v.byteOffset) + "; its buffer has " +
                              std::to_string(bytes.size()));
    return bytes.subspan(v.byteOffset, v.byteLength);
}

}  // namespace lumenfarm::import
