#pragma once

#include "common/imaging/appearance.h"
#include "common/solution/nearest_hits.h"
#include "common/solution/run_folder.h"
#include "common/solution/texel_fit.h"

#include <cstdint>

/// The light that arrives where a camera looks, and what a diffuse surface makes of it.
namespace lumenfarm {

/// Where pictures take their light from.
enum class Estimator : std::uint8_t {
    automatic,     ///< kept hits when the solution has any, else texels
    texels,        ///< averages of texels, as wide as the number of hits asks
    nearest_hits,  ///< nearest kept hits: finer detail, exact colours, more noise
};

class IncidentLight {
public:
    /// REQUIRES: both outlive this.
    IncidentLight(const LoadedRun& run, const Appearance& appearance, Estimator estimator);

    /// An estimate at a point, to be reused for its closest surroundings.
    struct Local {
        SurfacePoint point;
        double reuse_m = 0;
        PointEstimate estimate;
        HitNeighbourhood hits;  ///< when nearest hits are used
    };
    Local at(const SurfacePoint& point) const;
    bool reusable(const Local& local, const SurfacePoint& point) const;

    /// E albedo, linear sRGB [lx]: divided by pi it is the radiance that leaves.
    Vec3d reflected(const Local& local, const ColorSlot& diffuse, Vec2f uv) const;

private:
    PointEstimate from_texels(const SurfacePoint& point) const;

    const LoadedRun& run_;
    const Appearance& appearance_;
    TickValue tick_;
    TriangleIndex index_;
    TexelFit texels_;
    NearestHits nearest_;
    bool use_nearest_;
    std::uint32_t neighbours_;
};

}  // namespace lumenfarm
