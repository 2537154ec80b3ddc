#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "common/solution/solution.h"
#include "common/solution/texel_layout.h"
#include "common/transport/emission.h"

#include <cstdint>
#include <vector>

/// From ticks to photometric quantities with standard errors (docs/estimates.md).
namespace lumenfarm {

/// Particles of each light that the solution holds.
std::vector<std::uint64_t> committed_particles(const Solution& solution);

/// What one radiant tick is worth [W] and what one XYZ tick is worth (Y: lm).
struct TickValue {
    double watts = 0;
    double lumens = 0;
};
TickValue tick_value(const Emission& emission, const Solution& solution);

/// Light that arrives on an area. `relative_error` is standard_error_lx / illuminance_lx and, like the error, NaN when
/// nothing says how large it is (no hit, or fewer than two batches that emitted).
struct AreaEstimate {
    double area_m2 = 0;
    double irradiance_w_m2 = 0;
    double illuminance_lx = 0;
    double standard_error_lx = 0;
    double relative_error = 0;
    std::uint64_t hits = 0;
};

/// A surface: what arrives on each side over the one-sided area, and on both sides together over that same area.
struct SurfaceEstimate {
    AreaEstimate total, front, back;
};

/// Standard error of the ratio of sums over batches of particles [Cochran 1977, eq. 2.45]: with y_b the ticks that
/// arrived, e_b the ticks emitted and B the batches that emitted, R = sum y_b / sum e_b,
/// relative error = sqrt(B / (B - 1) sum (y_b - R e_b)^2) / sum y_b.
std::vector<SurfaceEstimate> surface_estimates(const Scene& scene, const Emission& emission, const Solution& solution);

/// Total of triangle areas of each surface, one side [m2].
std::vector<double> surface_areas_m2(const Scene& scene);

/// A texel: XYZ irradiance (Y in lx), radiant irradiance, and the variance of Y's estimate. Hits are independent events
/// of varying size, so the variance of a sum is the sum of squares (compound Poisson).
struct TexelEstimate {
    Vec3d xyz_lx;
    double irradiance_w_m2 = 0;
    double variance_lx2 = 0;
    std::uint64_t hits = 0;
};
/// REQUIRES: area_m2 > 0, the texel's area.
TexelEstimate texel_estimate(const TexelSums& sums, double area_m2, const TickValue& tick);

}  // namespace lumenfarm
