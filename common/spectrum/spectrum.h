#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Spectra as the whole program holds them: a value each 5 nm, linear between. Wavelengths that particles carry are
/// indices of 0.1 nm bins, so that every quantity that depends on the wavelength is a table.
namespace lumenfarm {

inline constexpr double wavelength_min_nm = 380.0;
inline constexpr double wavelength_max_nm = 780.0;
inline constexpr double sample_step_nm = 5.0;
inline constexpr std::size_t spectrum_samples = 81;    ///< at 380, 385, ... 780 nm
inline constexpr std::size_t wavelength_bins = 4'000;  ///< of 0.1 nm
inline constexpr std::size_t bins_per_sample = 50;
static_assert(wavelength_bins == (spectrum_samples - 1) * bins_per_sample);

/// Value at 380 + 5 i nm. Reflectances are in [0, 1]; light spectra are relative; refractive indices are absolute.
struct Spectrum {
    std::array<float, spectrum_samples> samples{};
    bool operator==(const Spectrum&) const = default;
};

/// Centre of a wavelength bin in nm.
constexpr double wavelength_nm(std::uint32_t bin) {
    return wavelength_min_nm + (bin + 0.5) * (wavelength_max_nm - wavelength_min_nm) / wavelength_bins;
}

/// Linear interpolation at the centre of `bin`. REQUIRES: bin < wavelength_bins. Exact for a constant spectrum.
constexpr double value_at(const Spectrum& spectrum, std::uint32_t bin) {
    const std::size_t i = bin / bins_per_sample;
    const double fraction = (static_cast<double>(bin % bins_per_sample) + 0.5) * (1.0 / bins_per_sample);
    const double low = spectrum.samples[i];
    return low + fraction * (spectrum.samples[i + 1] - low);
}

/// Linear interpolation at any wavelength; the end values continue outside [380, 780] nm.
double value_at_nm(const Spectrum& spectrum, double nm);

Spectrum constant_spectrum(double value);

}  // namespace lumenfarm
