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

/// The planned work counts as so many hits: what was measured outweighs it as soon as there is much more of that.
inline constexpr double planned_hits = 10'000;

/// What to cut by, after some of the job was traced: what was planned, corrected by hits.
std::vector<SpreadWork> corrected_work(std::vector<SpreadWork> planned, std::span<const SpreadWork> measured);

}  // namespace lumenfarm
