#pragma once

#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/support/result.h"

#include <array>
#include <cstdint>
#include <vector>

/// Who emits how much: the fluxes, the share of the particles, the wavelengths and the energies in ticks. Pure
/// functions of (scene, job spec) that master, worker and readers of a solution compute alike.
namespace lumenfarm {

inline constexpr std::uint32_t wavelength_guide_size = 16'384;

/// One light's wavelengths and energies. A particle draws its wavelength bin from the light's spectrum times a
/// visibility weight w, and carries ticks ~ 1 / w so that the expected spectrum is the light's.
struct LightEmission {
    double flux_w = 0;               ///< radiant flux
    double flux_lm = 0;              ///< luminous flux
    double share = 0;                ///< of all particles; flux_w over the sum of fluxes
    std::vector<double> cumulative;  ///< wavelength_bins + 1 values from 0 to 1: the bin's distribution
    /// Lowest bin that a chance in [g, g + 1) / wavelength_guide_size can draw: where a search of `cumulative` starts.
    std::vector<std::uint16_t> wavelength_guide;
    std::vector<std::uint32_t> energy;        ///< ticks of a particle of each bin, at most limits::energy_ticks_max
    double mean_energy_ticks = 0;             ///< expectation over the bins
    std::vector<double> triangle_cumulative;  ///< surface lights: by area, one more than triangles
};

struct Emission {
    std::vector<LightEmission> lights;
    double flux_w = 0;
    double flux_lm = 0;
};

/// Errors: bad_input when the scene has no light or a flux is zero or not finite.
Result<Emission> make_emission(const Scene& scene);

/// Particles of each light when `particles` are shared by Sainte-Lague's method, which is house-monotone: more
/// particles never take one from a light, so that an extended job keeps every particle. Sums to `particles`.
std::vector<std::uint64_t> apportion(const Emission& emission, std::uint64_t particles);

/// What one tick is worth when `committed[l]` particles of each light are in the result: the fluxes over the expected
/// ticks. [W]. 0 when nothing is committed.
double watts_per_tick(const Emission& emission, const std::vector<std::uint64_t>& committed);

/// CIE XYZ of energy: contribution = (ticks * ratio + 2^19) >> 20, ratio = round(2^20 x-bar) and so on: an XYZ tick is
/// worth watts_per_tick watts times 683 lm/W.
struct XyzRatios {
    std::array<std::uint32_t, 3> xyz;
};
const std::array<XyzRatios, wavelength_bins>& xyz_ratios();

}  // namespace lumenfarm
