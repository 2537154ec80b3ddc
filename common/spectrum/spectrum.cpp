#include "common/spectrum/spectrum.h"

#include <algorithm>

namespace lumenfarm {

double value_at_nm(const Spectrum& spectrum, double nm) {
    const double position = std::clamp((nm - wavelength_min_nm) / sample_step_nm, 0.0, spectrum_samples - 1.0);
    const std::size_t i = std::min(static_cast<std::size_t>(position), spectrum_samples - 2);
    const double low = spectrum.samples[i];
    return low + (position - static_cast<double>(i)) * (spectrum.samples[i + 1] - low);
}

Spectrum constant_spectrum(double value) {
    Spectrum spectrum;
    spectrum.samples.fill(static_cast<float>(value));
    return spectrum;
}

}  // namespace lumenfarm
