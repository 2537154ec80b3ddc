#pragma once

#include "common/scene/scene.h"
#include "common/support/result.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// Pictures of any format that OpenImageIO reads, as 8-bit sRGB without alpha.
namespace lumenfarm::import {

using Rgb8 = std::array<std::uint8_t, 3>;

struct Picture {
    std::uint32_t width = 0, height = 0;
    std::vector<Rgb8> pixels;  ///< row by row from the top
};

/// Errors: bad_input (missing, damaged, too large, floating-point picture); the sentence has `name`.
Result<Picture> read_picture(const std::filesystem::path& path, const std::string& name);
/// PNG or JPEG from memory.
Result<Picture> decode_picture(std::span<const std::byte> bytes, const std::string& name);

/// Reflectance coefficients of the pixels.
Texture to_texture(const Picture& picture);
/// Mean in linear sRGB. REQUIRES: it has pixels.
Vec3d mean_colour(const Picture& picture);

}  // namespace lumenfarm::import
