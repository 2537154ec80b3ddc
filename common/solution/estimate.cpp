#include "common/solution/estimate.h"

#include "common/spectrum/cie.h"

#include <cmath>
#include <limits>
#include <span>

namespace lumenfarm {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct SideSums {
    std::array<BatchSums, limits::batches> batches{};
    BatchSums total;
};

SideSums side_sums(const SurfaceBatches& sides, bool front, bool back) {
    SideSums sums;
    for (std::size_t b = 0; b < limits::batches; ++b) {
        if (front) sums.batches[b] += sides[0][b];
        if (back) sums.batches[b] += sides[1][b];
        sums.total += sums.batches[b];
    }
    return sums;
}

double relative_error(const SideSums& sums, const EnergyBalance& balance) {
    if (sums.total.y <= 0 || balance.emitted <= 0) return unknown;
    const double ratio = static_cast<double>(sums.total.y) / static_cast<double>(balance.emitted);
    double squares = 0;
    int batches = 0;
    for (std::size_t b = 0; b < limits::batches; ++b) {
        if (balance.emitted_by_batch[b] == 0) continue;
        const double off =
            static_cast<double>(sums.batches[b].y) - ratio * static_cast<double>(balance.emitted_by_batch[b]);
        squares += off * off;
        ++batches;
    }
    if (batches < 2) return unknown;
    return std::sqrt(squares * batches / (batches - 1)) / static_cast<double>(sums.total.y);
}

AreaEstimate area_estimate(const SideSums& sums, double area_m2, const EnergyBalance& balance, const TickValue& tick) {
    AreaEstimate estimate;
    estimate.area_m2 = area_m2;
    estimate.irradiance_w_m2 = static_cast<double>(sums.total.radiant) * tick.watts / area_m2;
    estimate.illuminance_lx = static_cast<double>(sums.total.y) * tick.lumens / area_m2;
    estimate.relative_error = relative_error(sums, balance);
    estimate.standard_error_lx = estimate.relative_error * estimate.illuminance_lx;
    estimate.hits = sums.total.hits;
    return estimate;
}

}  // namespace

std::vector<std::uint64_t> committed_particles(const Solution& solution) {
    std::vector<std::uint64_t> particles;
    particles.reserve(solution.committed.size());
    for (const IntervalSet& set : solution.committed) particles.push_back(set.size());
    return particles;
}

TickValue tick_value(const Emission& emission, const Solution& solution) {
    const double watts = watts_per_tick(emission, committed_particles(solution));
    return {watts, luminous_efficacy_lm_w * watts};
}

std::vector<double> surface_areas_m2(const Scene& scene) {
    std::vector<double> areas;
    areas.reserve(scene.surfaces.size());
    for (const Surface& surface : scene.surfaces) {
        double area = 0;
        for (std::uint32_t i = 0; i < surface.triangle_count; ++i)
            area += triangle_area_m2(scene, surface.first_triangle + i);
        areas.push_back(area);
    }
    return areas;
}

std::vector<SurfaceEstimate> surface_estimates(const Scene& scene, const Emission& emission, const Solution& solution) {
    const TickValue tick = tick_value(emission, solution);
    const std::vector<double> areas = surface_areas_m2(scene);
    std::vector<SurfaceEstimate> estimates;
    estimates.reserve(areas.size());
    for (std::size_t i = 0; i < areas.size(); ++i) {
        const SurfaceBatches& sides = solution.surfaces[i];
        const auto over = [&](bool front, bool back) {
            return area_estimate(side_sums(sides, front, back), areas[i], solution.balance, tick);
        };
        estimates.push_back({over(true, true), over(true, false), over(false, true)});
    }
    return estimates;
}

TexelEstimate texel_estimate(const TexelSums& sums, double area_m2, const TickValue& tick) {
    const double lux = tick.lumens / area_m2;
    const double shifted_lux = lux * (1 << y_squared_shift);
    TexelEstimate estimate;
    estimate.xyz_lx = {static_cast<double>(sums.x) * lux, static_cast<double>(sums.y) * lux,
                       static_cast<double>(sums.z) * lux};
    estimate.irradiance_w_m2 = static_cast<double>(sums.radiant) * tick.watts / area_m2;
    estimate.variance_lx2 = static_cast<double>(sums.y_squared) * shifted_lux * shifted_lux;
    estimate.hits = sums.hits;
    return estimate;
}

}  // namespace lumenfarm
