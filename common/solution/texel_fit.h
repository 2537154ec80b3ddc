#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "common/solution/estimate.h"
#include "common/solution/solution.h"
#include "common/solution/surface_point.h"
#include "common/solution/texel_layout.h"
#include "common/solution/triangle_index.h"

#include <cstdint>
#include <vector>

/// Light at a point from the texels around it: a local polynomial fit, so that neither a gradient nor an edge of the
/// surface pulls the estimate aside [Fan and Gijbels 1996, ch. 3] (docs/estimates.md).
namespace lumenfarm {

/// Light that arrives at a point. The error is NaN where no hit says how large it is.
struct PointEstimate {
    Vec3d xyz_lx;  ///< Y is the illuminance
    double irradiance_w_m2 = 0;
    double standard_error_lx = 0;
    std::uint64_t hits = 0;
    double radius_m = 0;
};

/// Degree of the polynomial. The bias of the estimate is of the first degree that is left out.
enum class FitDegree : std::uint8_t { constant, linear, quadratic };

class TexelFit {
public:
    /// REQUIRES: all outlive this; `solution` belongs to the scene and the layout.
    TexelFit(const Scene& scene, const TriangleIndex& index, const TexelLayout& layout, const Solution& solution,
             const TickValue& tick);

    /// Fit over the texels whose centroid lies within `radius_m`, weighted (1 - (d/r)^2)^2 times their area. Falls to a
    /// lower degree where the texels do not carry the one asked for, and to the point's own texel where none is near.
    PointEstimate at(const SurfacePoint& point, double radius_m, FitDegree degree) const;

    /// Hits per square metre around the point, weighted as above.
    double hits_per_m2(const SurfacePoint& point, double radius_m) const;

    /// Edge of the texels at the point [m].
    double texel_m(const SurfacePoint& point) const;

private:
    struct Sample {
        double u, v;  ///< in the point's tangent plane, in units of the radius
        double weight;
        double area_m2;
        std::uint64_t texel;
    };
    void gather(const SurfacePoint& point, double radius_m, std::vector<Sample>& samples) const;
    void gather_triangle(const SurfacePoint& point, std::uint32_t triangle, double radius_m,
                         std::vector<Sample>& samples) const;
    PointEstimate combine(const std::vector<Sample>& samples, const std::vector<double>& shares, double radius_m) const;

    const Scene& scene_;
    const TriangleIndex& index_;
    const TexelLayout& layout_;
    const Solution& solution_;
    TickValue tick_;
    double texel_m_;
};

}  // namespace lumenfarm
