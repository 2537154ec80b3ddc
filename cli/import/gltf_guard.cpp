#include "cli/import/gltf_guard.h"

#include "common/support/bytes.h"
#include "common/support/limits.h"

#include <string>

namespace lumenfarm::import {
namespace {

constexpr std::uint32_t glb_magic = 0x46546c67, json_chunk = 0x4e4f534a, bin_chunk = 0x004e4942;
constexpr std::size_t glb_header_bytes = 12, chunk_header_bytes = 8;

struct Chunk {
    std::uint32_t type = 0;
    std::span<const std::byte> bytes;
};

Result<Chunk> take_chunk(std::span<const std::byte>& rest) {
    ByteReader header(rest);
    const auto size = header.value<std::uint32_t>();
    const auto type = header.value<std::uint32_t>();
    if (!header.good() || size > rest.size() - chunk_header_bytes)
        return bad_input("the GLB is truncated: a chunk of " + std::to_string(size) + " bytes in the last " +
                         std::to_string(rest.size()));
    const Chunk chunk{type, rest.subspan(chunk_header_bytes, size)};
    rest = rest.subspan(chunk_header_bytes + size);
    return chunk;
}

}  // namespace

Result<void> check_json_shape(std::string_view json) {
    std::size_t depth = 0, values = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (in_string) {
            if (c == '\\') ++i;
            if (c == '"') in_string = false;
            continue;
        }
        if (c == '"') in_string = true;
        if (c == '[' || c == '{') ++depth;
        if ((c == ']' || c == '}') && depth > 0) --depth;
        if (c == '[' || c == '{' || c == ',') ++values;
        if (depth > limits::json_depth_max)
            return bad_input("the JSON nests deeper than " + std::to_string(limits::json_depth_max) + " levels");
        if (values > limits::json_values_max)
            return bad_input("the JSON has more than " + std::to_string(limits::json_values_max) + " values");
    }
    return {};
}

Result<std::string_view> glb_json(std::span<const std::byte> bytes) {
    ByteReader header(bytes);
    const auto magic = header.value<std::uint32_t>();
    const auto version = header.value<std::uint32_t>();
    const auto length = header.value<std::uint32_t>();
    if (!header.good() || magic != glb_magic) return bad_input("this is not a GLB: its first bytes are not 'glTF'");
    if (version != 2) return bad_input("the GLB has version " + std::to_string(version) + "; version 2 is read");
    if (length > bytes.size() || length < glb_header_bytes)
        return bad_input("the GLB is truncated: it says " + std::to_string(length) + " bytes and has " +
                         std::to_string(bytes.size()));
    std::span<const std::byte> rest = bytes.subspan(glb_header_bytes, length - glb_header_bytes);
    const auto json = take_chunk(rest);
    if (!json) return json.error();
    if (json->type != json_chunk) return bad_input("the GLB's first chunk is not JSON");
    if (!rest.empty()) {
        const auto binary = take_chunk(rest);
        if (!binary) return binary.error();
        if (binary->type != bin_chunk) return bad_input("the GLB's second chunk is not binary");
    }
    return std::string_view(reinterpret_cast<const char*>(json->bytes.data()), json->bytes.size());
}

}  // namespace lumenfarm::import
