#pragma once

#include "cli/import/import.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

/// Files that import tests write, in a folder that goes with the test.
namespace lumenfarm::test {

class ImportFolder {
public:
    ImportFolder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "lumenfarm-import-XXXXXX").string();
        if (mkdtemp(pattern.data()) != nullptr) path_ = pattern;
    }
    ImportFolder(const ImportFolder&) = delete;
    ImportFolder& operator=(const ImportFolder&) = delete;
    ~ImportFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

    std::filesystem::path write(const std::string& name, const std::string& bytes) const {
        std::ofstream(path_ / name, std::ios::binary) << bytes;
        return path_ / name;
    }

private:
    std::filesystem::path path_;
};

template <class T>
std::string bytes_of(const std::vector<T>& values) {
    std::string bytes(values.size() * sizeof(T), '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

/// `text` with the first `from` replaced; the test fails when it is not there.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// A square of 1 m in the plane z = 0 that looks to +z, in two triangles, as glTF beside "mesh.bin".
inline const std::string square_gltf = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"name": "square", "mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}]}],
"materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
 {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
 {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}],
"bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12},
 {"buffer": 0, "byteOffset": 60, "byteLength": 32}],
"buffers": [{"uri": "mesh.bin", "byteLength": 92}]})";

inline std::string square_bin(std::vector<float> positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0},
                              std::vector<std::uint16_t> indices = {0, 1, 2, 0, 2, 3}) {
    return bytes_of(positions) + bytes_of(indices) + bytes_of(std::vector<float>{0, 0, 1, 0, 1, 1, 0, 1});
}

/// A GLB of one JSON and one binary chunk.
inline std::string glb(std::string json, std::string binary) {
    while (json.size() % 4 != 0) json += ' ';
    while (binary.size() % 4 != 0) binary += '\0';
    const auto word = [](std::size_t value) { return bytes_of(std::vector<std::uint32_t>{std::uint32_t(value)}); };
    return "glTF" + word(2) + word(12 + 8 + json.size() + 8 + binary.size()) + word(json.size()) + "JSON" + json +
           word(binary.size()) + std::string("BIN\0", 4) + binary;
}

/// 2 x 2 pixels: red, green; middle grey, white.
inline std::string tiny_png() {
    const std::vector<std::uint8_t> bytes{0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49,
                                          0x48, 0x44, 0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02,
                                          0x00, 0x00, 0x00, 0xfd, 0xd4, 0x9a, 0x73, 0x00, 0x00, 0x00, 0x15, 0x49, 0x44,
                                          0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8, 0xcf, 0xc0, 0xc0, 0x00, 0xc4, 0x0d, 0x0d,
                                          0x0d, 0xff, 0xff, 0xff, 0x07, 0x00, 0x23, 0x72, 0x06, 0x7c, 0x78, 0xaf, 0xdc,
                                          0x6e, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
    return bytes_of(bytes);
}

/// The scene of the square after a change to its text; fails the test when it is refused.
inline ImportedScene import_square(const std::string& from = "asset", const std::string& to = "asset",
                                   const std::string& bin = square_bin()) {
    const ImportFolder folder;
    folder.write("mesh.bin", bin);
    folder.write("picture.png", tiny_png());
    auto result = import_scene(folder.write("square.gltf", replaced(square_gltf, from, to)), {});
    EXPECT_TRUE(result) << result.error().sentence;
    return result ? *result : ImportedScene{};
}

inline bool warns_of(const ImportedScene& imported, const std::string& part) {
    for (const std::string& warning : imported.warnings)
        if (warning.find(part) != std::string::npos) return true;
    return false;
}

}  // namespace lumenfarm::test
