#include "common/transport/launch.h"

#include "common/math/philox.h"
#include "common/math/sampling.h"
#include "common/math/sobol.h"

#include <algorithm>

namespace lumenfarm {
namespace {

constexpr std::uint32_t guide_size = 4096;
/// Counter words that no bounce uses: they give the scrambles of a light's Sobol points.
constexpr std::uint32_t scramble_bounce = 0xffffffffu;

}  // namespace

Launcher::Launcher(const Scene& scene, const Emission& emission, const std::vector<TriangleRecord>& triangles,
                   std::uint64_t seed, std::uint32_t light)
    : scene_(&scene), light_(&scene.lights[light]), emission_(&emission.lights[light]), triangles_(&triangles) {
    const auto low = philox(seed, {0, light, scramble_bounce, 0});
    const auto high = philox(seed, {0, light, scramble_bounce, 1});
    scramble_ = {low[0], low[1], low[2], low[3], high[0], high[1]};
    const auto& cumulative = emission_->cumulative;
    std::uint16_t bin = 0;
    for (std::uint32_t g = 0; g < guide_size; ++g) {
        while (bin + 1u < wavelength_bins && cumulative[bin + 1u] <= static_cast<double>(g) / guide_size) ++bin;
        bin_guide_.push_back(bin);
    }
}

double Launcher::coordinate(std::uint32_t particle, Dimension dimension) const {
    return uniform(owen_scramble(sobol(particle, dimension), scramble_[dimension]));
}

std::uint32_t Launcher::wavelength_bin(double u) const {
    std::uint32_t bin = bin_guide_[static_cast<std::uint32_t>(u * guide_size)];
    while (bin + 1 < wavelength_bins && emission_->cumulative[bin + 1] <= u) ++bin;
    return bin;
}

void Launcher::leave_surface(std::uint32_t particle, LaunchedParticle& launched) const {
    const Surface& surface = scene_->surfaces[light_->surface];
    const auto& cumulative = emission_->triangle_cumulative;
    // the triangle takes the first coordinate, which is stretched over it again
    double u = coordinate(particle, area_u);
    const auto above = std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, u);
    const auto t = static_cast<std::uint32_t>(above - cumulative.begin() - 1);
    u = std::clamp((u - cumulative[t]) / (cumulative[t + 1] - cumulative[t]), 0.0, 1.0);
    launched.from_triangle = surface.first_triangle + t;
    const TriangleRecord& triangle = (*triangles_)[launched.from_triangle];
    const Barycentrics b = sample_triangle(u, coordinate(particle, area_v));
    launched.origin = point_on(triangle, b.b1, b.b2);
    const bool back = scene_->materials[surface.material].double_sided && coordinate(particle, side) < 0.5;
    const Vec3d local = sample_cosine_hemisphere(coordinate(particle, angle_u), coordinate(particle, angle_v));
    launched.direction = frame_about(back ? -triangle.normal : triangle.normal).to_world(local);
}

LaunchedParticle Launcher::launch(std::uint32_t particle) const {
    LaunchedParticle launched;
    launched.wavelength = wavelength_bin(coordinate(particle, wavelength));
    launched.energy = emission_->energy[launched.wavelength];
    if (light_->kind == LightKind::surface) {
        leave_surface(particle, launched);
        return launched;
    }
    launched.origin = light_->position;
    const double u = coordinate(particle, angle_u);
    const double v = coordinate(particle, angle_v);
    const Frame axis = frame_about(light_->direction);
    if (light_->kind == LightKind::spot)
        launched.direction = axis.to_world(sample_spot(u, v, coordinate(particle, area_u), coordinate(particle, area_v),
                                                       light_->cos_inner, light_->cos_outer));
    else if (light_->lambertian)
        launched.direction = axis.to_world(sample_cosine_hemisphere(u, v));
    else
        launched.direction = sample_uniform_zone(u, v, -1, 1);
    return launched;
}

}  // namespace lumenfarm
