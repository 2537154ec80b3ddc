#pragma once

#include "common/octree/partition.h"
#include "common/octree/weighted_octree.h"
#include "common/support/result.h"

#include <cstdint>
#include <span>
#include <vector>

/// Space cut into the units of the object-space strategy (docs/subspaces.md).
namespace lumenfarm {

/// A box whose particles one worker traces at a time.
struct Subspace {
    Box box;            ///< [m]; for rays, the outermost boxes reach to infinity
    double weight = 0;  ///< of the octree's leaves in it, those at its bounds in part
};

/// Subspaces of near-equal weight, and where they lie.
class Subspaces {
public:
    /// Cuts the root across its longest edge so that the halves have the weights of their shares of `count`, and so
    /// each half, down to boxes of one share. A leaf's weight counts as spread evenly in it. Errors: bad_input (count
    /// is 0, or more than the octree has non-empty leaves).
    static Result<Subspaces> cut(const WeightedOctree& weighted, std::uint32_t count);
    /// The largest count that cut() takes.
    static std::uint64_t most(const WeightedOctree& weighted);

    std::span<const Subspace> all() const { return subspaces_; }
    const Partition& partition() const { return partition_; }
    /// For each subspace the triangles that come within `margin_m` of it, and few others, in ascending order. There may
    /// be none. REQUIRES: the octree was made from this scene.
    std::vector<std::vector<std::uint32_t>> triangles(const Scene& scene, double margin_m) const;

private:
    Partition partition_;
    std::vector<Subspace> subspaces_;
};

}  // namespace lumenfarm
