#pragma once

#include "common/math/vec.h"
#include "common/spectrum/spectrum.h"

/// Linear sRGB to smooth spectra [Jakob and Hanika 2019, A Low-Dimensional Function Space for Efficient Spectral
/// Upsampling]: s(l) = 1/2 + p / (2 sqrt(1 + p^2)), p = c0 t^2 + c1 t + c2, t = (l - 380 nm) / 400 nm.
namespace lumenfarm {

/// Coefficients c0, c1, c2 of one colour. A grey gives c0 = c1 = 0: it is constant over wavelength, exactly.
struct SigmoidCoefficients {
    float c0 = 0, c1 = 0, c2 = 0;
    bool operator==(const SigmoidCoefficients&) const = default;
};

/// The reflectance whose colour under D65 is `rgb` (clamped to [0, 1]); the same machine gives the same bits; error in
/// sRGB below 1e-3 for colours inside the gamut of smooth reflectances.
SigmoidCoefficients reflectance_coefficients(Vec3d rgb);

/// Reflectance in [0, 1] at the centre of a bin; black and white are exactly 0 and 1. REQUIRES: finite coefficients.
/// Only + - * / sqrt: the same bits on every machine.
double reflectance_at(SigmoidCoefficients coefficients, std::uint32_t bin);

/// The same reflectance as a table. A grey is the table of that number, so black and white are exactly 0 and 1.
Spectrum reflectance_spectrum(Vec3d rgb);

/// A light's relative spectrum whose chromaticity is that of `rgb` >= 0: twice the reflectance of rgb / (2 max(rgb)),
/// times D65. Its luminance over that of D65 is that of rgb / max(rgb); white gives D65 itself.
/// REQUIRES: some component > 0.
Spectrum light_spectrum(Vec3d rgb);

}  // namespace lumenfarm
