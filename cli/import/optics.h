#pragma once

#include "common/math/vec.h"
#include "common/spectrum/spectrum.h"

#include <array>

/// From the few numbers of a scene file to spectra.
namespace lumenfarm::import {

/// Y of linear sRGB. [IEC 61966-2-1]
double luminance_of(Vec3d linear_srgb);

/// Reflectance at normal incidence ((n - 1) / (n + 1))^2.
double normal_reflectance(double refractive_index);

/// Cauchy's n = A + B / lambda^2 through n_d at 587.56 nm with Abbe number (n_d - 1) / (n_F - n_C), F 486.13 nm,
/// C 656.27 nm. REQUIRES: abbe > 0.
Spectrum cauchy_index(double n_d, double abbe);

/// Sellmeier's n^2 = 1 + sum B_i l^2 / (l^2 - C_i), l and sqrt(C_i) in micrometres. Where n^2 < 0 the sample is 0.
Spectrum sellmeier_index(const std::array<double, 3>& b, const std::array<double, 3>& c_um2);

}  // namespace lumenfarm::import
