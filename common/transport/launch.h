#pragma once

#include "common/math/philox.h"
#include "common/math/sampling.h"
#include "common/math/sobol.h"
#include "common/scene/scene.h"
#include "common/transport/emission.h"
#include "common/transport/ray_query.h"
#include "common/transport/triangle_lanes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

/// How a particle leaves its light: the first dimensions of law 2, from an Owen-scrambled Sobol point at its index.
namespace lumenfarm {

/// Particles of consecutive indices at their light, a lane each.
struct LaunchLanes {
    RayLanes rays;
    Lanes<std::uint32_t> wavelength{};  ///< bin
    Lanes<std::uint32_t> energy{};      ///< ticks
};

class Launcher {
public:
    /// `triangles`: of a surface light, its own. `clearance`: of the scene, or one that is clear nowhere.
    /// REQUIRES: the arguments outlive this.
    Launcher(const Scene& scene, const Emission& emission, const SceneExtent& extent, const TriangleRecord* triangles,
             const ClearanceMap& clearance, std::uint64_t seed, std::uint32_t light);
    /// Particles `first`, `first` + 1 ... REQUIRES: `first` is a multiple of lane_count.
    void launch(std::uint32_t first, LaunchLanes& launched) const;

private:
    enum Dimension : std::uint32_t { area_u, area_v, angle_u, angle_v, wavelength, side };
    static_assert(lane_count == sobol_block);

    std::uint32_t wavelength_bin(double u) const;
    std::uint32_t triangle_below(double u) const;
    void leave_surface(const SobolBlock& points, RayLanes& rays) const;
    void leave_point(const SobolBlock& points, RayLanes& rays) const;

    const Scene* scene_;
    const Light* light_;
    const LightEmission* emission_;
    const TriangleRecord* triangles_;  ///< of the light
    const ClearanceMap* clearance_;
    SceneExtent extent_;
    bool clear_light_;
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

inline void Launcher::leave_surface(const SobolBlock& points, RayLanes& rays) const {
    const Surface& surface = scene_->surfaces[light_->surface];
    const auto& cumulative = emission_->triangle_cumulative;
    TriangleLanes triangles;
    Lanes<std::uint32_t> chosen;
    Lanes<double> below, share;
    for (std::size_t k = 0; k < lane_count; ++k) {
        const std::uint32_t t = chosen[k] = triangle_below(uniform(points[area_u][k]));
        below[k] = cumulative[t];
        share[k] = cumulative[t + 1] - cumulative[t];
        rays.from_triangle[k] = surface.first_triangle + t;
    }
    triangles.gather(triangles_, chosen);
    const double back_share = scene_->materials[surface.material].double_sided ? 0.5 : 0;
    Lanes<double> b1, b2;
    for (std::size_t k = 0; k < lane_count; ++k) {
        // the triangle took the first coordinate, which is stretched over it again
        const double stretched = (uniform(points[area_u][k]) - below[k]) / share[k];
        const double u = stretched < 0 ? 0 : stretched > 1 ? 1 : stretched;
        const Barycentrics b = sample_triangle(u, uniform(points[area_v][k]));
        b1[k] = b.b1;
        b2[k] = b.b2;
        rays.origin.set(k, triangles.point(k, b.b1, b.b2));
        const Vec3d front = triangles.unit_normal(k);
        const Vec3d normal = uniform(points[side][k]) < back_share ? -front : front;
        const Vec3d direction =
            sample_cosine_about(normal, uniform_float(points[angle_u][k]), uniform_float(points[angle_v][k]));
        rays.direction.set(k, direction);
        rays.clear_start[k] = dot(direction, normal) >= RayQuery::steep_cosine;
    }
    for (std::size_t k = 0; k < lane_count; ++k)
        rays.clear_start[k] &= clearance_->is_clear(triangles_[chosen[k]].clearance, b1[k], b2[k]);
}

inline void Launcher::leave_point(const SobolBlock& points, RayLanes& rays) const {
    const Frame<double> axis = frame_about(light_->direction);
    for (std::size_t k = 0; k < lane_count; ++k) {
        const double u = uniform(points[angle_u][k]);
        const double v = uniform(points[angle_v][k]);
        const Vec3d direction =
            light_->kind == LightKind::spot
                ? axis.to_world(sample_spot(u, v, uniform(points[area_u][k]), uniform(points[area_v][k]),
                                            light_->cos_inner, light_->cos_outer))
            : light_->lambertian ? axis.to_world(sample_cosine_hemisphere(u, v))
                                 : sample_uniform_zone(u, v, -1, 1);
        rays.origin.set(k, extent_.approached(light_->position, direction));
        rays.direction.set(k, direction);
        rays.from_triangle[k] = none;
        rays.clear_start[k] = clear_light_;
    }
}

inline void Launcher::launch(std::uint32_t first, LaunchLanes& launched) const {
    const SobolBlock points = scrambled_sobol(first, scramble_);
    for (std::size_t k = 0; k < lane_count; ++k) {
        launched.wavelength[k] = wavelength_bin(uniform(points[wavelength][k]));
        launched.energy[k] = emission_->energy[launched.wavelength[k]];
    }
    if (light_->kind == LightKind::surface)
        leave_surface(points, launched.rays);
    else
        leave_point(points, launched.rays);
}

}  // namespace lumenfarm
