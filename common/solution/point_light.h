#pragma once

#include "common/solution/nearest_hits.h"
#include "common/solution/texel_fit.h"

#include <optional>

/// Illuminance at a point for `measure`: the smallest neighbourhood that reaches a wanted precision.
namespace lumenfarm {

/// Relative standard error at which a neighbourhood stops growing.
inline constexpr double point_error_wanted = 0.01;

/// Texels by a quadratic fit over a radius of 2 texels or more, until the error is reached or the radius is 8 texels;
/// kept hits instead, when enough of them for the same error lie closer than that.
PointEstimate estimate_at(const TexelFit& texels, const NearestHits& hits, const SurfacePoint& point);

/// The side that receives more. REQUIRES: `points` is not empty.
struct MeasuredPoint {
    SurfacePoint point;
    PointEstimate estimate;
};
MeasuredPoint estimate_brighter(const TexelFit& texels, const NearestHits& hits,
                                const std::vector<SurfacePoint>& points);

}  // namespace lumenfarm
