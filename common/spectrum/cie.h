#pragma once

#include "common/math/vec.h"
#include "common/spectrum/spectrum.h"

/// CIE 1931 2-degree colour-matching functions, the luminous efficacy, and the way to sRGB.
namespace lumenfarm {

inline constexpr double luminous_efficacy_lm_w = 683.0;  ///< K_m [lm/W]

/// x-bar, y-bar (= V), z-bar, each 5 nm [CIE 015:2018, table 5].
const Spectrum& cie_x();
const Spectrum& cie_y();
const Spectrum& cie_z();
/// CIE standard illuminant D65, relative, 100 at 560 nm.
const Spectrum& illuminant_d65();

/// Integral over 380..780 nm of the product of two spectra, each piecewise linear, summed over the 0.1 nm bins [nm].
double integral(const Spectrum& a, const Spectrum& b);
/// Integral over 380..780 nm [nm].
double integral(const Spectrum& a);

/// Luminous efficacy of radiation [lm/W]: 683 * integral(S V) / integral(S). REQUIRES: integral(S) > 0.
double efficacy_lm_w(const Spectrum& light);

/// CIE XYZ (Y = 1 is white) to linear sRGB with D65 white, no gamut mapping. [IEC 61966-2-1]
Vec3d xyz_to_linear_srgb(Vec3d xyz);
Vec3d linear_srgb_to_xyz(Vec3d rgb);
/// The sRGB transfer curve; clamps to [0, 1].
double srgb_encode(double linear);
double srgb_decode(double encoded);

}  // namespace lumenfarm
