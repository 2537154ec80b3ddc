#pragma once

#include "common/scene/scene.h"
#include "common/support/result.h"

#include <cstdint>
#include <string>

/// How fast the tracer is beside bare Embree, on this thread.
namespace lumenfarm {

struct TracerBench {
    double rays_per_s = 0;         ///< traced, with all that is done at a hit
    double embree_rays_per_s = 0;  ///< one rtcIntersect1 for each of the very same rays, nothing else
    double ratio = 0;              ///< of the two: the median of the rounds' ratios
    double particles_per_s = 0;
    double hits_per_particle = 0;
    std::uint64_t rays = 0;  ///< in a round
    std::uint64_t particles = 0;
    std::uint64_t triangles = 0;
    std::string isa;
    std::uint32_t rounds = 0;
};

/// Records the rays of `particles` particles of the scene's brightest light; then, in alternating rounds, traces them
/// again and asks Embree for the recorded rays. Seconds are CPU time of this thread; the figures are medians.
/// `particles` 0: enough for about two million rays. Errors: bad_input (no light, too many particles), failed (Embree).
Result<TracerBench> bench_tracer(const Scene& scene, std::uint64_t particles, std::uint32_t rounds,
                                 const std::string& isa);

}  // namespace lumenfarm
