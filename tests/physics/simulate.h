#pragma once

#include "common/scene/scene.h"
#include "common/scene/scene_file.h"
#include "common/solution/estimate.h"
#include "common/solution/solution.h"
#include "common/transport/tracer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>

/// A whole solution in the test's own process, and the pass rule of the oracles.
namespace lumenfarm::testing {

struct Simulated {
    std::unique_ptr<TracerScene> tracer;
    std::unique_ptr<TexelLayout> layout;
    Solution solution;
    std::vector<SurfaceEstimate> surfaces;
};

/// Traces the whole job in slices and estimates every surface. The balance is checked as an equality of integers.
inline Simulated simulate(const Scene& scene, const JobSpec& spec) {
    const auto valid = validate(scene);
    EXPECT_TRUE(valid.has_value()) << (valid ? "" : valid.error().sentence);
    Simulated s;
    s.tracer = std::move(TracerScene::make(scene).value());
    const Box box = bounding_box(scene);
    s.layout = std::make_unique<TexelLayout>(
        TexelLayout::make(scene, texel_in_force_m(spec, length(box.high - box.low))).value());
    LightMap map(*s.layout);
    KeptHits kept(spec.keep_hits);
    s.solution.spec = spec;
    s.solution.committed.resize(scene.lights.size());
    const auto counts = apportion(s.tracer->emission(), spec.particles);
    TracedHits hits;
    for (std::uint32_t light = 0; light < counts.size(); ++light) {
        for (std::uint64_t first = 0; first < counts[light]; first += 20'000) {
            const std::uint64_t count = std::min<std::uint64_t>(20'000, counts[light] - first);
            hits.records.clear();
            hits.energies.clear();
            s.tracer->trace(spec, {light, first, count}, hits);
            map.add(s.tracer->emission(), light, hits.records, hits.energies);
            s.solution.committed[light].insert(first, first + count);
        }
    }
    s.solution.balance = hits.balance;
    s.solution.texels = map.texels();
    s.solution.surfaces = map.surfaces();
    s.surfaces = surface_estimates(scene, s.tracer->emission(), s.solution);
    EXPECT_TRUE(s.solution.balance.closed());
    EXPECT_EQ(s.solution.balance.particles, spec.particles);
    return s;
}

/// Oracle rule: within four standard errors, and the standard error below the tolerance.
inline void expect_oracle(double estimate, double standard_error, double truth, double relative_tolerance,
                          const std::string& what) {
    EXPECT_LT(standard_error, relative_tolerance * truth) << what << ": too few particles to be sharp";
    EXPECT_LT(std::abs(estimate - truth), 4 * standard_error)
        << what << ": " << estimate << " +- " << standard_error << ", expected " << truth;
}

inline void expect_illuminance(const AreaEstimate& estimate, double truth_lx, double relative_tolerance,
                               const std::string& what) {
    expect_oracle(estimate.illuminance_lx, estimate.standard_error_lx, truth_lx, relative_tolerance, what);
}

/// Mean over all surfaces; its standard error by batches of particles over all of them together, as estimate.h has it.
inline AreaEstimate area_mean(const Simulated& s) {
    AreaEstimate mean;
    std::array<double, limits::batches> arrived{};
    double total = 0;
    for (std::size_t i = 0; i < s.surfaces.size(); ++i) {
        mean.area_m2 += s.surfaces[i].total.area_m2;
        mean.hits += s.surfaces[i].total.hits;
        for (const auto& side : s.solution.surfaces[i])
            for (std::size_t b = 0; b < limits::batches; ++b) arrived[b] += static_cast<double>(side[b].y);
    }
    for (const double ticks : arrived) total += ticks;
    const auto& emitted = s.solution.balance.emitted_by_batch;
    const double ratio = total / static_cast<double>(s.solution.balance.emitted);
    double squares = 0;
    for (std::size_t b = 0; b < limits::batches; ++b)
        squares += std::pow(arrived[b] - ratio * static_cast<double>(emitted[b]), 2);
    mean.illuminance_lx = total * tick_value(s.tracer->emission(), s.solution).lumens / mean.area_m2;
    mean.relative_error = std::sqrt(squares * limits::batches / (limits::batches - 1)) / total;
    mean.standard_error_lx = mean.relative_error * mean.illuminance_lx;
    return mean;
}

inline JobSpec particles(std::uint64_t count) {
    JobSpec spec;
    spec.particles = count;
    return spec;
}

}  // namespace lumenfarm::testing
