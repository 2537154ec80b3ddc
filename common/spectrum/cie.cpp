#include "common/spectrum/cie.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <cmath>

namespace lumenfarm {
namespace {

constexpr double bin_nm = (wavelength_max_nm - wavelength_min_nm) / wavelength_bins;

}  // namespace

double integral(const Spectrum& a, const Spectrum& b) {
    double sum = 0;
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) sum += value_at(a, bin) * value_at(b, bin);
    return sum * bin_nm;
}

double integral(const Spectrum& a) {
    double sum = 0;
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) sum += value_at(a, bin);
    return sum * bin_nm;
}

double efficacy_lm_w(const Spectrum& light) {
    const double power = integral(light);
    ensure(power > 0, "a light's spectrum has power");
    return luminous_efficacy_lm_w * integral(light, cie_y()) / power;
}

// The two matrices follow from the primaries of BT.709 and the white (0.3127, 0.3290), and are inverse to each other.
Vec3d xyz_to_linear_srgb(Vec3d xyz) {
    return {3.2409699419045213 * xyz.x - 1.5373831775700935 * xyz.y - 0.4986107602930033 * xyz.z,
            -0.9692436362808798 * xyz.x + 1.8759675015077206 * xyz.y + 0.0415550574071756 * xyz.z,
            0.0556300796969936 * xyz.x - 0.2039769588889765 * xyz.y + 1.0569715142428784 * xyz.z};
}

Vec3d linear_srgb_to_xyz(Vec3d rgb) {
    return {0.4123907992659595 * rgb.x + 0.3575843393838780 * rgb.y + 0.1804807884018343 * rgb.z,
            0.2126390058715104 * rgb.x + 0.7151686787677559 * rgb.y + 0.0721923153607337 * rgb.z,
            0.0193308187155918 * rgb.x + 0.1191947797946259 * rgb.y + 0.9505321522496608 * rgb.z};
}

double srgb_encode(double linear) {
    const double value = std::clamp(linear, 0.0, 1.0);
    if (value <= 0.0031308) return 12.92 * value;
    return value < 1 ? 1.055 * std::pow(value, 1 / 2.4) - 0.055 : 1;
}

double srgb_decode(double encoded) {
    const double value = std::clamp(encoded, 0.0, 1.0);
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

}  // namespace lumenfarm
