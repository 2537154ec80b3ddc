#pragma once

#include "common/math/philox.h"
#include "common/math/sampling.h"
#include "common/math/sobol.h"
#include "common/scene/scene.h"
#include "common/transport/emission.h"
#include "common/transport/ray_query.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

/// How a particle leaves its light: the first dimensions of law 2, from an Owen-scrambled Sobol point at its index.
namespace lumenfarm {

struct LaunchedParticle {
    Vec3d origin;
    Vec3d direction;  ///< unit
    std::uint32_t from_triangle = none;
    std::uint32_t wavelength = 0;  ///< bin
    std::uint32_t energy = 0;      ///< ticks
};

class Launcher {
public:
    /// REQUIRES: the arguments outlive this.
    Launcher(const Scene& scene, const Emission& emission, const std::vector<TriangleRecord>& triangles,
             std::uint64_t seed, std::uint32_t light);
    LaunchedParticle launch(std::uint32_t particle) const;

private:
    enum Dimension : std::uint32_t { area_u, area_v, angle_u, angle_v, wavelength, side };
    std::uint32_t wavelength_bin(double u) const;
    std::uint32_t triangle_below(double u) const;
    void leave_surface(const SobolPoint& point, LaunchedParticle& launched) const;

    const Scene* scene_;
    const Light* light_;
    const LightEmission* emission_;
    const std::vector<TriangleRecord>* triangles_;
    SobolPoint scramble_;
};

inline std::uint32_t Launcher::wavelength_bin(double u) const {
    std::uint32_t bin = emission_->wavelength_guide[static_cast<std::uint32_t>(u * wavelength_guide_size)];
    // one step without a branch settles nearly all; cumulative ends with 1, which no u reaches
    bin += emission_->cumulative[bin + 1] <= u;
    while (emission_->cumulative[bin + 1] <= u) ++bin;
    return bin;
}

inline std::uint32_t Launcher::triangle_below(double u) const {
    const auto& cumulative = emission_->triangle_cumulative;
    constexpr std::size_t few = 9;
    if (cumulative.size() > few) {
        const auto above = std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, u);
        return static_cast<std::uint32_t>(above - cumulative.begin() - 1);
    }
    // counting has no branch to mispredict
    std::uint32_t below = 0;
    for (std::size_t t = 1; t + 1 < cumulative.size(); ++t) below += cumulative[t] <= u;
    return below;
}

inline void Launcher::leave_surface(const SobolPoint& point, LaunchedParticle& launched) const {
    const Surface& surface = scene_->surfaces[light_->surface];
    const auto& cumulative = emission_->triangle_cumulative;
    // the triangle takes the first coordinate, which is stretched over it again
    double u = uniform(point[area_u]);
    const std::uint32_t t = triangle_below(u);
    u = std::clamp((u - cumulative[t]) / (cumulative[t + 1] - cumulative[t]), 0.0, 1.0);
    launched.from_triangle = surface.first_triangle + t;
    const TriangleRecord& triangle = (*triangles_)[launched.from_triangle];
    const Barycentrics b = sample_triangle(u, uniform(point[area_v]));
    launched.origin = point_on(triangle, b.b1, b.b2);
    const bool back = scene_->materials[surface.material].double_sided && uniform(point[side]) < 0.5;
    const Vec3d local = sample_cosine_hemisphere(uniform(point[angle_u]), uniform(point[angle_v]));
    launched.direction = frame_about(back ? -triangle.normal : triangle.normal).to_world(local);
}

inline LaunchedParticle Launcher::launch(std::uint32_t particle) const {
    const SobolPoint point = scrambled_sobol(particle, scramble_);
    LaunchedParticle launched;
    launched.wavelength = wavelength_bin(uniform(point[wavelength]));
    launched.energy = emission_->energy[launched.wavelength];
    if (light_->kind == LightKind::surface) {
        leave_surface(point, launched);
        return launched;
    }
    launched.origin = light_->position;
    const double u = uniform(point[angle_u]);
    const double v = uniform(point[angle_v]);
    const Frame axis = frame_about(light_->direction);
    if (light_->kind == LightKind::spot)
        launched.direction = axis.to_world(
            sample_spot(u, v, uniform(point[area_u]), uniform(point[area_v]), light_->cos_inner, light_->cos_outer));
    else if (light_->lambertian)
        launched.direction = axis.to_world(sample_cosine_hemisphere(u, v));
    else
        launched.direction = sample_uniform_zone(u, v, -1, 1);
    return launched;
}

}  // namespace lumenfarm
