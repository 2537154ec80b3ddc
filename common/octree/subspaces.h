#pragma once

#include "common/octree/partition.h"
#include "common/octree/weighted_octree.h"
#include "common/support/result.h"

#include <cstdint>
#include <span>
#include <vector>

/// Space cut into the units of the object-space strategy (docs/subspaces.md).
namespace lumenfarm {

/// That a scene is cut into where nobody says how many, if it can be.
inline constexpr std::uint32_t automatic_subspaces = 64;

/// Work that is expected, or was measured, evenly in a box. The box may be flat, or a point.
struct SpreadWork {
    Box box;  ///< [m]
    double work = 0;
};

/// A box whose particles one worker traces at a time.
struct Subspace {
    Box box;            ///< [m]; for rays, the outermost boxes reach to infinity
    double weight = 0;  ///< of the work in it, of what lies at its bounds in part
};

/// Subspaces of near-equal weight, and where they lie.
class Subspaces {
public:
    /// Of the octree's root, by the weights of its leaves. Errors: bad_input (count is 0, or more than the octree has
    /// non-empty leaves).
    static Result<Subspaces> cut(const WeightedOctree& weighted, std::uint32_t count);
    /// Cuts the root across its longest edge, or where the work can't be parted so across another, so that the halves
    /// have the work of their shares of `count`, and so each half, down to boxes of one share.
    /// REQUIRES: 0 < count <= limits::subspaces_max; a root of some volume; work >= 0.
    static Subspaces cut(const Box& root, std::vector<SpreadWork> work, std::uint32_t count);
    /// Of a root that was cut like this, with weights that nobody knows (0). REQUIRES: the partition is not empty.
    static Subspaces of(const Box& root, Partition partition);
    /// The largest count that cut() takes.
    static std::uint64_t most(const WeightedOctree& weighted);

    std::span<const Subspace> all() const { return subspaces_; }
    const Box& root() const { return root_; }
    /// How much of the work lies in each, by the middles of its boxes.
    std::vector<double> shares(std::span<const SpreadWork> work) const;
    const Partition& partition() const { return partition_; }
    /// For each subspace the triangles that come within `margin_m` of it, and few others, in ascending order. There may
    /// be none. REQUIRES: the octree was made from this scene.
    std::vector<std::vector<std::uint32_t>> triangles(const Scene& scene, double margin_m) const;

private:
    Box root_;
    Partition partition_;
    std::vector<Subspace> subspaces_;
};

/// The octree's leaves and their weights.
std::vector<SpreadWork> planned_work(const WeightedOctree& weighted);

/// The largest of the shares over their mean; 1 when there is nothing.
double imbalance(std::span<const double> shares);

}  // namespace lumenfarm
