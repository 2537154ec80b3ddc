#pragma once

#include "common/scene/scene.h"
#include "common/support/result.h"

#include <cstdint>
#include <string>
#include <vector>

/// How evenly cuts in subspaces share out what tracing takes (docs/subspaces.md).
namespace lumenfarm {

/// The largest share of a subspace over the mean.
struct CutFigures {
    std::string cut;
    double of_hits = 1;
    double of_time = 1;  ///< processor time
};

/// Of a cut in equal volumes, of that planned by the weighted octree, and of `learned_cuts` after it, each learned from
/// what was traced under those before, the first from hits alone. Each is measured by particles of its own, in parts,
/// on this thread. Errors: bad_input (no light, subspaces or particles that can't be), failed (Embree).
Result<std::vector<CutFigures>> bench_cuts(const Scene& scene, std::uint32_t subspaces, std::uint32_t learned_cuts,
                                           std::uint64_t particles);

}  // namespace lumenfarm
