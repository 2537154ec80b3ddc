#include "cli/import/image.h"

#include "common/scene/text.h"
#include "common/spectrum/cie.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <array>
#include <memory>
#include <unordered_map>

namespace lumenfarm::import {
namespace {

Error refuse(const std::string& name, const std::string& why) {
    return bad_input("the picture '" + clean_name(name) + "' " + clean_name(why));
}

Vec3d to_linear(Rgb8 rgb) {
    const auto linear = [](std::uint8_t v) { return srgb_decode(v / 255.0); };
    return {linear(rgb[0]), linear(rgb[1]), linear(rgb[2])};
}

/// One solve for each distinct colour: pictures repeat them.
class CoefficientMemo {
public:
    SigmoidCoefficients operator()(Rgb8 rgb) {
        const std::uint32_t key = rgb[0] | rgb[1] << 8 | rgb[2] << 16;
        const auto [place, is_new] = by_colour_.try_emplace(key);
        if (is_new) {
            place->second = reflectance_coefficients(to_linear(rgb));
        }
        return place->second;
    }

private:
    std::unordered_map<std::uint32_t, SigmoidCoefficients> by_colour_;
};

Result<void> check_size(const OIIO::ImageSpec& spec, const std::string& name) {
    const auto most = static_cast<int>(limits::texture_side_max);
    if (spec.width < 1 || spec.height < 1 || spec.width > most || spec.height > most || spec.depth > 1 ||
        spec.nchannels < 1 || spec.nchannels > 4)
        return refuse(name, "has " + std::to_string(spec.width) + " x " + std::to_string(spec.height) + " pixels of " +
                                std::to_string(spec.nchannels) + " channels; at most " + std::to_string(most) +
                                " to a side and 4 channels are read");
    if (static_cast<std::uint64_t>(spec.width) * spec.height > limits::texture_texels_max)
        return refuse(name, "has more than " + std::to_string(limits::texture_texels_max) + " pixels");
    if (spec.format.is_floating_point())
        return refuse(name, "holds floating-point values; reflectances must be a picture of 8 or 16 bits");
    return {};
}

Result<Picture> read_pixels(OIIO::ImageInput& input, const std::string& name) {
    const OIIO::ImageSpec spec = input.spec();
    if (auto size = check_size(spec, name); !size) return size.error();
    const auto channels = static_cast<std::size_t>(spec.nchannels);
    const auto pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
    std::vector<std::uint8_t> values(pixels * channels);
    if (!input.read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, values.data()))
        return refuse(name, "cannot be decoded: " + input.geterror());
    Picture picture{static_cast<std::uint32_t>(spec.width), static_cast<std::uint32_t>(spec.height), {}};
    picture.pixels.reserve(pixels);
    for (std::size_t p = 0; p < pixels; ++p) {
        const std::uint8_t* at = values.data() + p * channels;
        picture.pixels.push_back(channels >= 3 ? Rgb8{at[0], at[1], at[2]} : Rgb8{at[0], at[0], at[0]});
    }
    return picture;
}

bool starts_with(std::span<const std::byte> bytes, std::initializer_list<int> magic) {
    std::size_t i = 0;
    for (const int value : magic)
        if (i >= bytes.size() || std::to_integer<int>(bytes[i++]) != value) return false;
    return true;
}

}  // namespace

Result<Picture> read_picture(const std::filesystem::path& path, const std::string& name) {
    if (!std::filesystem::is_regular_file(path)) return refuse(name, "does not exist as a file");
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string());
    if (!input) return refuse(name, "cannot be read: " + OIIO::geterror());
    return read_pixels(*input, name);
}

Result<Picture> decode_picture(std::span<const std::byte> bytes, const std::string& name) {
    const bool png = starts_with(bytes, {0x89, 'P', 'N', 'G'});
    if (!png && !starts_with(bytes, {0xff, 0xd8, 0xff})) return refuse(name, "is neither PNG nor JPEG");
    OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes.data()), bytes.size());
    const std::unique_ptr<OIIO::ImageInput> input =
        OIIO::ImageInput::open(png ? "memory.png" : "memory.jpg", nullptr, &memory);
    if (!input) return refuse(name, "cannot be read: " + OIIO::geterror());
    return read_pixels(*input, name);
}

Texture to_texture(const Picture& picture) {
    Texture texture;
    texture.width = picture.width;
    texture.height = picture.height;
    texture.texels.reserve(picture.pixels.size());
    CoefficientMemo coefficients;
    for (const Rgb8 pixel : picture.pixels) texture.texels.push_back(coefficients(pixel));
    return texture;
}

Vec3d mean_colour(const Picture& picture) {
    Vec3d sum;
    for (const Rgb8 pixel : picture.pixels) sum = sum + to_linear(pixel);
    return sum * (1.0 / static_cast<double>(picture.pixels.size()));
}

}  // namespace lumenfarm::import
