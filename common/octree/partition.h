#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "common/support/result.h"

#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

/// Which subspace a ray is in (docs/subspaces.md).
namespace lumenfarm {

/// The stretch of a ray that lies in a subspace: distances in [enters, leaves), in units of the direction's length.
struct Stretch {
    std::uint32_t subspace = none;  ///< none: the ray is in no subspace any more
    double enters = 0;
    double leaves = std::numeric_limits<double>::infinity();
};

/// All of space, cut in two by planes across the axes, again and again. So is every ray by at(), to the bit: where one
/// stretch ends the next begins, in the same doubles on every PC, so that a meeting at some distance lies in one
/// subspace.
class Partition {
public:
    /// A cell, cut in two or not. 16 bytes.
    struct Node {
        double plane_m = 0;          ///< inner: where it is cut
        std::uint32_t first = none;  ///< inner: its lower half, behind which the upper one stands; none: a leaf
        std::uint32_t which = 0;     ///< inner: the axis that the plane is across; leaf: its subspace
        bool is_leaf() const { return first == none; }
        bool operator==(const Node&) const = default;
    };

    Partition() = default;
    /// REQUIRES: made by Subspaces::cut() or good by check().
    explicit Partition(std::vector<Node> nodes) : nodes_(std::move(nodes)) {}
    /// Foreign nodes: whether they are a tree whose leaves name the subspaces 0, 1 ... in order. Errors: bad_input.
    static Result<Partition> check(std::vector<Node> nodes);

    std::span<const Node> nodes() const { return nodes_; }
    std::uint32_t subspaces() const { return static_cast<std::uint32_t>((nodes_.size() + 1) / 2); }
    /// Where the ray is from a distance on. REQUIRES: not empty; finite; direction is not zero.
    Stretch at(Vec3d origin, Vec3d direction, double from) const;
    /// The subspace that a point lies in; in a plane, that above it. REQUIRES: not empty.
    std::uint32_t of(Vec3d point) const;
    bool operator==(const Partition&) const = default;

private:
    std::vector<Node> nodes_;
};

}  // namespace lumenfarm
