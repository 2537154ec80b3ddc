#include "cli/import/optics.h"

#include <cmath>

namespace lumenfarm::import {
namespace {

double sample_nm(std::size_t i) { return wavelength_min_nm + sample_step_nm * static_cast<double>(i); }

}  // namespace

double luminance_of(Vec3d linear_srgb) { return dot(linear_srgb, Vec3d{0.2126, 0.7152, 0.0722}); }

double normal_reflectance(double refractive_index) {
    const double ratio = (refractive_index - 1) / (refractive_index + 1);
    return ratio * ratio;
}

Spectrum cauchy_index(double n_d, double abbe) {
    constexpr double d_nm = 587.56, f_nm = 486.13, c_nm = 656.27;
    const double b = (n_d - 1) / (abbe * (1 / (f_nm * f_nm) - 1 / (c_nm * c_nm)));
    const double a = n_d - b / (d_nm * d_nm);
    Spectrum n;
    for (std::size_t i = 0; i < spectrum_samples; ++i)
        n.samples[i] = static_cast<float>(a + b / (sample_nm(i) * sample_nm(i)));
    return n;
}

Spectrum sellmeier_index(const std::array<double, 3>& b, const std::array<double, 3>& c_um2) {
    Spectrum n;
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        const double square_um2 = sample_nm(i) * sample_nm(i) * 1e-6;
        double n2 = 1;
        for (std::size_t term = 0; term < 3; ++term) n2 += b[term] * square_um2 / (square_um2 - c_um2[term]);
        n.samples[i] = n2 > 0 ? static_cast<float>(std::sqrt(n2)) : 0.0f;
    }
    return n;
}

}  // namespace lumenfarm::import
