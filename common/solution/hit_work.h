#pragma once

#include "common/octree/subspaces.h"
#include "common/scene/scene.h"
#include "common/solution/solution.h"
#include "common/solution/texel_layout.h"

#include <cstdint>
#include <span>
#include <vector>

/// Where in space the work of a job was, as its hits tell (docs/subspaces.md).
namespace lumenfarm {

/// The hits of each texel of either side, in the texel's bounding box; where there are too many texels, those of each
/// triangle. What has no hits is left out. REQUIRES: `layout` is of the scene, `texels` of the layout.
std::vector<SpreadWork> hit_work(const Scene& scene, const TexelLayout& layout, std::span<const TexelSums> texels);

/// What following particles took in a subspace.
struct SubspaceCost {
    std::uint64_t hits = 0;
    std::uint64_t nanoseconds = 0;
    bool operator==(const SubspaceCost&) const = default;
};

/// Fewer measured hits than these, on average over the subspaces, say nothing of what hits take.
inline constexpr double costed_hits_min = 100;

/// Work in hits, weighed by what hits took: where one takes twice the time of an average one, it counts as two. Time in
/// a subspace that had no hits lies evenly in it. `costs`: by subspace of `cut`; where nothing was measured, or little
/// in all, hits count as they are.
std::vector<SpreadWork> costed_work(std::vector<SpreadWork> hits, const Subspaces& cut,
                                    std::span<const SubspaceCost> costs);

/// The planned work counts as so many hits: what was measured outweighs it as soon as there is much more of that.
inline constexpr double planned_hits = 10'000;

/// What to cut by, after some of the job was traced: what was planned, corrected by hits.
std::vector<SpreadWork> corrected_work(std::vector<SpreadWork> planned, std::span<const SpreadWork> measured);

}  // namespace lumenfarm
