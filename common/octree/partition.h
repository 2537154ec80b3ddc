#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "common/support/result.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

/// Which subspace a ray is in (docs/subspaces.md).
namespace lumenfarm {

/// The stretch of a ray that lies in a subspace: distances in [enters, leaves), in units of the direction's length.
struct Stretch {
    std::uint32_t subspace = none;  ///< none: the ray meets no other subspace
    double enters = 0;
    double leaves = std::numeric_limits<double>::infinity();
};

/// All of space, cut into subspaces and the empty cells between them. So is every ray by next(), to the bit: where one
/// stretch ends the next begins, in the same doubles on every PC, so that a meeting at some distance lies in one
/// subspace.
class Partition {
public:
    /// A cell, split in eight or not.
    struct Node {
        Vec3d middle;                   ///< inner: where the planes cross [m]
        std::uint32_t first = none;     ///< inner: of eight children, in the octree's order; none: a leaf
        std::uint32_t subspace = none;  ///< leaf: none when it is empty
        bool operator==(const Node&) const = default;
    };

    Partition() = default;
    /// REQUIRES: made by Subspaces::cut() or good by check().
    explicit Partition(std::vector<Node> nodes);
    /// Foreign nodes: whether they are a tree whose leaves name the subspaces 0, 1 ... once each, in order. Errors:
    /// bad_input.
    static Result<Partition> check(std::vector<Node> nodes);

    std::span<const Node> nodes() const { return nodes_; }
    std::uint32_t subspaces() const { return subspaces_; }
    /// The first subspace that the ray is in at distance `from` or later. REQUIRES: finite; direction is not zero.
    Stretch next(Vec3d origin, Vec3d direction, double from) const;
    bool operator==(const Partition&) const = default;

private:
    std::vector<Node> nodes_;
    std::uint32_t subspaces_ = 0;
};

}  // namespace lumenfarm
