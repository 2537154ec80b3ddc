#pragma once

#include "common/imaging/picture.h"
#include "common/support/result.h"

#include <cstdint>
#include <filesystem>
#include <span>

/// Pictures as files: written beside the path and renamed, so that no half-written file is ever seen.
namespace lumenfarm {

/// OpenEXR with the float channels R, G, B, illuminance_lx, relative_error and hit_count (docs/estimates.md).
/// Errors: bad_input (the name does not end in .exr), failed (the sentence names the path and the reason).
Result<void> write_exr(const std::filesystem::path& path, const Picture& picture);

/// `rgb`: 3 bytes a pixel, sRGB. REQUIRES: rgb.size() == 3 * width * height. Errors: as above, for .png.
Result<void> write_png(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
                       std::span<const std::uint8_t> rgb);

}  // namespace lumenfarm
