#pragma once

#include "common/octree/partition.h"
#include "common/octree/weighted_octree.h"
#include "common/support/result.h"

#include <cstdint>
#include <span>
#include <vector>

/// Space cut into the units of the object-space strategy (docs/subspaces.md).
namespace lumenfarm {

/// A cell of the weighted octree whose particles one worker traces at a time.
struct Subspace {
    OctreeCell cell;
    Box box;            ///< [m]; for rays, the outermost cells reach to infinity
    double weight = 0;  ///< > 0
};

/// Subspaces of near-equal weight, and where they lie.
class Subspaces {
public:
    /// Splits the heaviest cell until there are as many non-empty cells as they can be without being more than `count`.
    /// Errors: bad_input (count is 0, or more than the octree has non-empty leaves).
    static Result<Subspaces> cut(const WeightedOctree& weighted, std::uint32_t count);
    /// The largest count that cut() takes.
    static std::uint64_t most(const WeightedOctree& weighted);

    std::span<const Subspace> all() const { return subspaces_; }
    const Partition& partition() const { return partition_; }
    /// For each subspace the triangles that come within `margin_m` of it, and few others, in ascending order. A cell
    /// that the octree counts as filled may have none: its triangles miss it by no more than rounding. REQUIRES: the
    /// octree was made from this scene.
    std::vector<std::vector<std::uint32_t>> triangles(const Scene& scene, double margin_m) const;

private:
    Partition partition_;
    std::vector<Subspace> subspaces_;
};

}  // namespace lumenfarm
