#include "common/imaging/picture_file.h"

#include "common/support/ensure.h"

#include <OpenImageIO/imageio.h>

#include <unistd.h>

#include <exception>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

namespace lumenfarm {
namespace {

constexpr int exr_channels = 6;
static_assert(sizeof(Pixel) == exr_channels * sizeof(float));

Error unwritten(const std::filesystem::path& path, const std::string& reason) {
    return failed("cannot write '" + path.string() + "': " + (reason.empty() ? "unknown reason" : reason));
}

/// The name keeps its ending, by which the format is chosen.
std::filesystem::path beside(const std::filesystem::path& path) {
    return path.parent_path() / (".part-" + std::to_string(::getpid()) + "-" + path.filename().string());
}

Result<void> write_beside(const std::filesystem::path& part, const std::filesystem::path& path,
                          const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* pixels) {
    try {
        const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(part.string());
        if (!output) return unwritten(path, OIIO::geterror());
        if (!output->open(part.string(), spec) || !output->write_image(type, pixels) || !output->close())
            return unwritten(path, output->geterror());
    } catch (const std::exception& error) {
        return unwritten(path, error.what());
    }
    return {};
}

Result<void> write_whole(const std::filesystem::path& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
                         const void* pixels) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) return unwritten(path, "it is a folder");
    const std::filesystem::path part = beside(path);
    const auto written = write_beside(part, path, spec, type, pixels);
    if (written) std::filesystem::rename(part, path, error);
    if (written && !error) return {};
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    return written ? Result<void>(unwritten(path, error.message())) : written;
}

Result<void> require_ending(const std::filesystem::path& path, const char* ending) {
    if (path.extension() == ending) return {};
    return bad_input("'" + path.string() + "' does not end in " + ending);
}

}  // namespace

Result<void> write_exr(const std::filesystem::path& path, const Picture& picture) {
    if (const auto named = require_ending(path, ".exr"); !named) return named;
    OIIO::ImageSpec spec(static_cast<int>(picture.width), static_cast<int>(picture.height), exr_channels,
                         OIIO::TypeDesc::FLOAT);
    spec.channelnames = {"R", "G", "B", "illuminance_lx", "relative_error", "hit_count"};
    spec.attribute("compression", "zip");
    return write_whole(path, spec, OIIO::TypeDesc::FLOAT, picture.pixels.data());
}

Result<void> write_png(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
                       std::span<const std::uint8_t> rgb) {
    ensure(rgb.size() == std::size_t{3} * width * height, "the picture has three bytes a pixel");
    if (const auto named = require_ending(path, ".png"); !named) return named;
    OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    return write_whole(path, spec, OIIO::TypeDesc::UINT8, rgb.data());
}

}  // namespace lumenfarm
