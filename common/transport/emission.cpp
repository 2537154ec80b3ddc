#include "common/transport/emission.h"

#include "common/spectrum/cie.h"
#include "common/support/ensure.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

namespace lumenfarm {
namespace {

/// Share of the wavelengths that are drawn without regard to visibility; bounds 1 / weight and so a particle's energy.
constexpr double unweighted_share = 0.25;

/// Weight of a wavelength by its effect on the eye: a quarter uniform, the rest as x-bar + y-bar + z-bar; mean 1.
const std::array<double, wavelength_bins>& visibility_weight() {
    static const std::array<double, wavelength_bins> weights = [] {
        std::array<double, wavelength_bins> w{};
        double sum = 0;
        for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) {
            w[bin] = value_at(cie_x(), bin) + value_at(cie_y(), bin) + value_at(cie_z(), bin);
            sum += w[bin];
        }
        for (double& weight : w) weight = unweighted_share + (1 - unweighted_share) * weight * wavelength_bins / sum;
        return w;
    }();
    return weights;
}

double light_area_m2(const Scene& scene, const Surface& surface) {
    double area = 0;
    for (std::uint32_t t = 0; t < surface.triangle_count; ++t)
        area += triangle_area_m2(scene, surface.first_triangle + t);
    return area;
}

/// Solid angle that full axial intensity would need to give the light's flux [sr].
double equivalent_solid_angle_sr(const Light& light) {
    if (light.kind == LightKind::spot) {
        // inner cone, then the integral of ((c - c_o) / (c_i - c_o))^2 over c: a third of the width
        return 2 * std::numbers::pi * ((1 - light.cos_inner) + (light.cos_inner - light.cos_outer) / 3);
    }
    return light.lambertian ? std::numbers::pi : 4 * std::numbers::pi;
}

double flux_lm(const Scene& scene, const Light& light) {
    if (light.kind != LightKind::surface) return light.photometric * equivalent_solid_angle_sr(light);
    const Surface& surface = scene.surfaces[light.surface];
    const double sides = scene.materials[surface.material].double_sided ? 2 : 1;
    return std::numbers::pi * light.photometric * light_area_m2(scene, surface) * sides;
}

/// p_i ~ S_i w_i and energy_i ~ 1 / w_i with mean energy_ticks_nominal: p_i energy_i ~ S_i, the light's own spectrum.
void fill_wavelengths(const Spectrum& spectrum, LightEmission& light) {
    const auto& weight = visibility_weight();
    double power = 0;
    double weighted = 0;
    light.cumulative.assign(wavelength_bins + 1, 0);
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) {
        const double s = value_at(spectrum, bin);
        power += s;
        weighted += s * weight[bin];
        light.cumulative[bin + 1] = weighted;
    }
    for (double& c : light.cumulative) c /= weighted;
    light.cumulative.back() = 1;
    light.energy.resize(wavelength_bins);
    const double scale = limits::energy_ticks_nominal * weighted / power;
    for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin) {
        const double energy = std::floor(scale / weight[bin] + 0.5);
        light.energy[bin] =
            static_cast<std::uint32_t>(std::clamp(energy, 1.0, static_cast<double>(limits::energy_ticks_max)));
        light.mean_energy_ticks += (light.cumulative[bin + 1] - light.cumulative[bin]) * light.energy[bin];
    }
}

void fill_guide(LightEmission& light) {
    std::uint16_t bin = 0;
    for (std::uint32_t g = 0; g < wavelength_guide_size; ++g) {
        while (bin + 1u < wavelength_bins &&
               light.cumulative[bin + 1u] <= static_cast<double>(g) / wavelength_guide_size)
            ++bin;
        light.wavelength_guide.push_back(bin);
    }
}

void fill_triangles(const Scene& scene, const Light& light, LightEmission& emission) {
    if (light.kind != LightKind::surface) return;
    const Surface& surface = scene.surfaces[light.surface];
    auto& cumulative = emission.triangle_cumulative;
    cumulative.assign(surface.triangle_count + 1, 0);
    for (std::uint32_t t = 0; t < surface.triangle_count; ++t)
        cumulative[t + 1] = cumulative[t] + triangle_area_m2(scene, surface.first_triangle + t);
    const double area = cumulative.back();
    for (double& c : cumulative) c /= area;
}

}  // namespace

Result<Emission> make_emission(const Scene& scene) {
    if (scene.lights.empty()) return bad_input("the scene has no light; --light adds one under the ceiling");
    Emission emission;
    for (const Light& light : scene.lights) {
        LightEmission e;
        const Spectrum& spectrum = scene.spectra[light.spectrum];
        e.flux_lm = flux_lm(scene, light);
        const double efficacy = integral(spectrum) > 0 ? efficacy_lm_w(spectrum) : 0;
        e.flux_w = efficacy > 0 ? e.flux_lm / efficacy : 0;
        if (!(e.flux_w > 0) || !std::isfinite(e.flux_w))
            return bad_input("the light '" + light.name + "' has a flux of " + std::to_string(e.flux_lm) +
                             " lm; it must be positive and visible");
        fill_wavelengths(spectrum, e);
        fill_guide(e);
        fill_triangles(scene, light, e);
        emission.flux_w += e.flux_w;
        emission.flux_lm += e.flux_lm;
        emission.lights.push_back(std::move(e));
    }
    for (LightEmission& light : emission.lights) light.share = light.flux_w / emission.flux_w;
    return emission;
}

std::vector<std::uint64_t> apportion(const Emission& emission, std::uint64_t particles) {
    const std::size_t count = emission.lights.size();
    std::vector<std::uint64_t> seats(count);
    std::uint64_t given = 0;
    // start below the answer: Sainte-Lague gives every light at least floor(share * (particles - lights)) - 1
    const double safe = std::max(0.0, static_cast<double>(particles) - static_cast<double>(count));
    for (std::size_t l = 0; l < count; ++l) {
        const auto start = static_cast<std::uint64_t>(emission.lights[l].share * safe);
        seats[l] = start > 1 ? start - 1 : 0;
        given += seats[l];
    }
    ensure(given <= particles, "the start lies below the apportionment");
    // the next seat goes to the largest share / (2 seats + 1), ties to the lower light
    struct Claim {
        double quotient;
        std::size_t light;
        bool operator<(const Claim& other) const {
            return quotient != other.quotient ? quotient < other.quotient : light > other.light;
        }
    };
    const auto claim = [&](std::size_t l) {
        return Claim{emission.lights[l].share / (2.0 * static_cast<double>(seats[l]) + 1.0), l};
    };
    std::priority_queue<Claim> claims;
    for (std::size_t l = 0; l < count; ++l) claims.push(claim(l));
    for (; given < particles; ++given) {
        const std::size_t l = claims.top().light;
        claims.pop();
        ++seats[l];
        claims.push(claim(l));
    }
    return seats;
}

double watts_per_tick(const Emission& emission, const std::vector<std::uint64_t>& committed) {
    double ticks = 0;
    for (std::size_t l = 0; l < emission.lights.size(); ++l)
        ticks += static_cast<double>(committed[l]) * emission.lights[l].mean_energy_ticks;
    return ticks > 0 ? emission.flux_w / ticks : 0;
}

const std::array<XyzRatios, wavelength_bins>& xyz_ratios() {
    static const std::array<XyzRatios, wavelength_bins> ratios = [] {
        std::array<XyzRatios, wavelength_bins> r{};
        const auto fixed = [](double value) { return static_cast<std::uint32_t>(value * 1048576.0 + 0.5); };
        for (std::uint32_t bin = 0; bin < wavelength_bins; ++bin)
            r[bin] = {{fixed(value_at(cie_x(), bin)), fixed(value_at(cie_y(), bin)), fixed(value_at(cie_z(), bin))}};
        return r;
    }();
    return ratios;
}

}  // namespace lumenfarm
