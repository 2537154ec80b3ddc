#include "common/imaging/tone_map.h"

#include "common/spectrum/cie.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lumenfarm {
namespace {

using Matrix = std::array<Vec3d, 3>;  ///< rows

Vec3d apply(const Matrix& m, Vec3d v) { return {dot(m[0], v), dot(m[1], v), dot(m[2], v)}; }

// Bradford cone responses and back [Lindbloom; CIE 160:2004]
constexpr Matrix to_cones{Vec3d{0.8951, 0.2664, -0.1614}, Vec3d{-0.7502, 1.7135, 0.0367},
                          Vec3d{0.0389, -0.0685, 1.0296}};
constexpr Matrix from_cones{Vec3d{0.9869929, -0.1470543, 0.1599627}, Vec3d{0.4323053, 0.5183603, 0.0492912},
                            Vec3d{-0.0085287, 0.0400428, 0.9684867}};
constexpr double adaptation = 0.8;  // eyes keep a little of a lamp's colour

double luminance(Vec3d rgb) { return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z; }

/// Gains of the cones that turn `white` towards D65.
Vec3d cone_gains(Vec3d white_rgb) {
    const Vec3d white = apply(to_cones, linear_srgb_to_xyz(white_rgb * (1 / luminance(white_rgb))));
    const Vec3d target = apply(to_cones, linear_srgb_to_xyz({1, 1, 1}));
    const auto gain = [](double from, double to) { return from > 1e-3 ? 1 + adaptation * (to / from - 1) : 1.0; };
    return {gain(white.x, target.x), gain(white.y, target.y), gain(white.z, target.z)};
}

/// Straight up to the knee, then a shoulder that reaches 1 at infinity with the same slope at the knee.
double shoulder(double x) {
    constexpr double knee = 0.6;
    if (x <= knee) return x;
    return 1 - (1 - knee) * (1 - knee) / (x - knee + 1 - knee);
}

/// Draws a colour towards the grey of its luminance until no component is below 0 or above 1.
Vec3d into_gamut(Vec3d rgb) {
    const double grey = std::clamp(luminance(rgb), 0.0, 1.0);
    double keep = 1;
    for (std::size_t i = 0; i < 3; ++i) {
        if (rgb[i] > 1) keep = std::min(keep, (1 - grey) / (rgb[i] - grey));
        if (rgb[i] < 0) keep = std::min(keep, grey / (grey - rgb[i]));
    }
    return Vec3d{grey, grey, grey} * (1 - keep) + rgb * keep;
}

double percentile(std::vector<double>& values, double fraction) {
    const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

}  // namespace

ToneMapping automatic_tone(const Picture& picture, Vec3d white) {
    // only what reflects light decides: a lamp in view shows no illuminance that explains its luminance
    constexpr double pi = 3.14159265358979323846;
    std::vector<double> lit;
    double log_sum = 0;
    for (const Pixel& pixel : picture.pixels) {
        const double seen = luminance(pixel.radiance.as<double>());
        if (!(seen > 0) || seen * pi > 1.5 * static_cast<double>(pixel.illuminance_lx)) continue;
        lit.push_back(seen);
        log_sum += std::log(seen);
    }
    if (lit.empty()) return {1, white};
    const double mean = std::exp(log_sum / static_cast<double>(lit.size()));
    const double bright = percentile(lit, 0.95);
    // bright surfaces at 0.7; where most of the picture is far darker than them, towards a mean of 0.18
    const double by_bright = 0.7 / bright, by_mean = 0.18 / mean;
    return {std::clamp(by_mean, by_bright, 6 * by_bright), white};
}

std::vector<std::uint8_t> tone_map(const Picture& picture, const ToneMapping& tone) {
    const Vec3d gains = luminance(tone.white) > 0 ? cone_gains(tone.white) : Vec3d{1, 1, 1};
    std::vector<std::uint8_t> bytes;
    bytes.reserve(picture.pixels.size() * 3);
    for (const Pixel& pixel : picture.pixels) {
        const Vec3d cones = apply(to_cones, linear_srgb_to_xyz(pixel.radiance.as<double>()));
        const Vec3d adapted =
            xyz_to_linear_srgb(apply(from_cones, {cones.x * gains.x, cones.y * gains.y, cones.z * gains.z}));
        const double exposed = std::max(luminance(adapted) * tone.exposure, 0.0);
        const double scale = exposed > 0 ? tone.exposure * shoulder(exposed) / exposed : 0;
        const Vec3d rgb = into_gamut(adapted * scale);
        for (std::size_t i = 0; i < 3; ++i)
            bytes.push_back(static_cast<std::uint8_t>(std::lround(srgb_encode(rgb[i]) * 255)));
    }
    return bytes;
}

}  // namespace lumenfarm
