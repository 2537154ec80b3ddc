#include "common/solution/point_light.h"

#include "common/support/ensure.h"

namespace lumenfarm {
namespace {

constexpr double first_radius_texels = 2;
constexpr double last_radius_texels = 8;
constexpr double growth = 1.25;
/// Equal hits that give the wanted error; three times as many allow for unequal ones.
constexpr auto hits_wanted = static_cast<std::uint32_t>(3 / (point_error_wanted * point_error_wanted));

bool precise(const PointEstimate& estimate) {
    return estimate.standard_error_lx <= point_error_wanted * estimate.xyz_lx.y;
}

PointEstimate from_texels(const TexelFit& texels, const SurfacePoint& point) {
    const double texel_m = texels.texel_m(point);
    PointEstimate estimate = texels.at(point, first_radius_texels * texel_m, FitDegree::quadratic);
    for (double radius = first_radius_texels * growth; radius <= last_radius_texels && !precise(estimate);
         radius *= growth)
        estimate = texels.at(point, radius * texel_m, FitDegree::quadratic);
    return estimate;
}

}  // namespace

PointEstimate estimate_at(const TexelFit& texels, const NearestHits& hits, const SurfacePoint& point) {
    const PointEstimate fitted = from_texels(texels, point);
    if (hits.empty()) return fitted;
    const HitNeighbourhood near = hits.around(point, hits_wanted, fitted.radius_m);
    if (!near.bounded_by_hit) return fitted;
    return hits.estimate(near);
}

MeasuredPoint estimate_brighter(const TexelFit& texels, const NearestHits& hits,
                                const std::vector<SurfacePoint>& points) {
    ensure(!points.empty(), "there is a point to measure");
    MeasuredPoint best{points[0], estimate_at(texels, hits, points[0])};
    for (std::size_t i = 1; i < points.size(); ++i) {
        const PointEstimate other = estimate_at(texels, hits, points[i]);
        if (other.xyz_lx.y > best.estimate.xyz_lx.y) best = {points[i], other};
    }
    return best;
}

}  // namespace lumenfarm
