#pragma once

#include "common/octree/weighted_octree.h"
#include "common/support/result.h"

#include <cstdint>
#include <limits>
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

/// The stretch of a ray that lies in a subspace: distances in [enters, leaves), in units of the direction's length.
struct Stretch {
    std::uint32_t subspace = none;  ///< none: the ray meets no other subspace
    double enters = 0;
    double leaves = std::numeric_limits<double>::infinity();
};

/// Subspaces of near-equal weight and the empty cells between them. They partition space, and by next() every ray, to
/// the bit: where one stretch ends the next begins, in the same doubles on every PC, so that a meeting at some distance
/// lies in one subspace.
class Subspaces {
public:
    /// Splits the heaviest cell until there are as many non-empty cells as they can be without being more than `count`.
    /// Errors: bad_input (count is 0, or more than the octree has non-empty leaves).
    static Result<Subspaces> cut(const WeightedOctree& weighted, std::uint32_t count);

    std::span<const Subspace> all() const { return subspaces_; }
    /// The first subspace that the ray is in at distance `from` or later. REQUIRES: finite; direction is not zero.
    Stretch next(Vec3d origin, Vec3d direction, double from) const;
    /// For each subspace the triangles that come within `margin_m` of it, and few others, in ascending order. A cell
    /// that the octree counts as filled may have none: its triangles miss it by no more than rounding. REQUIRES: the
    /// octree was made from this scene.
    std::vector<std::vector<std::uint32_t>> triangles(const Scene& scene, double margin_m) const;

private:
    struct Node {
        Vec3d middle;                   ///< inner: where the planes cross [m]
        std::uint32_t first = none;     ///< inner: of eight children, as in an octree; none: a leaf
        std::uint32_t subspace = none;  ///< leaf: none when it is empty
    };

    std::vector<Node> nodes_;
    std::vector<Subspace> subspaces_;
};

}  // namespace lumenfarm
