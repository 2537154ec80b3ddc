#include "common/imaging/incident_light.h"

#include "common/spectrum/cie.h"

#include <algorithm>
#include <cmath>

namespace lumenfarm {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double hits_wanted = 12'000;  // in a disc: 1.5 % of noise after the weights of the fit
constexpr double radius_min_texels = 1.5;
constexpr double radius_max_texels = 8;
constexpr double survey_texels = 3;  // radius of the density that chooses the radius
constexpr double reuse_radii = 0.2;  // within a pixel an estimate serves points this close, in its own radius
constexpr std::uint32_t neighbours_min = 16, neighbours_max = 1'000;
constexpr std::uint64_t hits_per_neighbour = 200;  // a neighbourhood is this part of all kept hits

}  // namespace

IncidentLight::IncidentLight(const LoadedRun& run, const Appearance& appearance, Estimator estimator)
    : run_(run),
      appearance_(appearance),
      tick_(tick_value(run.emission, run.solution)),
      index_(run.scene),
      texels_(run.scene, index_, run.layout, run.solution, tick_),
      nearest_(run.scene, index_, run.solution, tick_),
      use_nearest_(estimator != Estimator::texels && !nearest_.empty()),
      neighbours_(static_cast<std::uint32_t>(
          std::clamp<std::uint64_t>(run.solution.kept.size() / hits_per_neighbour, neighbours_min, neighbours_max))) {}

PointEstimate IncidentLight::from_texels(const SurfacePoint& point) const {
    const double texel_m = texels_.texel_m(point);
    const double density = texels_.hits_per_m2(point, survey_texels * texel_m);
    const double radius = density > 0 ? std::sqrt(hits_wanted / (pi * density)) : radius_max_texels * texel_m;
    return texels_.at(point, std::clamp(radius, radius_min_texels * texel_m, radius_max_texels * texel_m),
                      FitDegree::linear);
}

IncidentLight::Local IncidentLight::at(const SurfacePoint& point) const {
    const double texel_m = texels_.texel_m(point);
    Local local{point, 0, {}, {}};
    if (use_nearest_) {
        local.hits = nearest_.around(point, neighbours_, radius_max_texels * texel_m);
        local.estimate = nearest_.estimate(local.hits);
    } else {
        local.estimate = from_texels(point);
        // the fit may fall below 0 beside a steep edge
        Vec3d& xyz = local.estimate.xyz_lx;
        xyz = {std::max(xyz.x, 0.0), std::max(xyz.y, 0.0), std::max(xyz.z, 0.0)};
    }
    local.reuse_m = reuse_radii * local.estimate.radius_m;
    return local;
}

bool IncidentLight::reusable(const Local& local, const SurfacePoint& point) const {
    return local.point.triangle == point.triangle && local.point.side == point.side &&
           length(local.point.position - point.position) <= local.reuse_m;
}

Vec3d IncidentLight::reflected(const Local& local, const ColorSlot& diffuse, Vec2f uv) const {
    if (!use_nearest_) {
        const Vec3d light = xyz_to_linear_srgb(local.estimate.xyz_lx);
        const Vec3d albedo = appearance_.albedo(diffuse, uv);
        return {light.x * albedo.x, light.y * albedo.y, light.z * albedo.z};
    }
    if (!(local.hits.area_m2 > 0)) return {};
    // each kept hit knows its wavelength, so the albedo is that of the light that really came
    constexpr double one = 1 << 20;
    Vec3d xyz;
    for (const std::uint32_t i : local.hits.hits) {
        const KeptHit& hit = run_.solution.kept[i];
        const double albedo = appearance_.materials().albedo(diffuse, hit.record.wavelength, [&] { return uv; });
        const auto& ratio = xyz_ratios()[hit.record.wavelength].xyz;
        xyz = xyz + Vec3d{ratio[0] / one, ratio[1] / one, ratio[2] / one} * (hit.energy * albedo);
    }
    return xyz_to_linear_srgb(xyz * (nearest_.tick().lumens / local.hits.area_m2));
}

}  // namespace lumenfarm
