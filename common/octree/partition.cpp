#include "common/octree/partition.h"

#include "common/support/limits.h"

#include <algorithm>
#include <string>
#include <utility>

namespace lumenfarm {

Partition::Partition(std::vector<Node> nodes) : nodes_(std::move(nodes)) {
    for (const Node& node : nodes_) subspaces_ += node.subspace != none;
}

Result<Partition> Partition::check(std::vector<Node> nodes) {
    std::uint64_t next_child = 1;
    std::uint32_t next_subspace = 0;
    const auto wrong = [](std::size_t node) {
        return bad_input("node " + std::to_string(node) + " of the partition is out of place");
    };
    // children stand in the order of their parents, or they would not all be below the root once
    std::vector<std::size_t> inner;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Node& node = nodes[i];
        if (node.first == none) {
            if (node.subspace != none && node.subspace != next_subspace++) return wrong(i);
            continue;
        }
        const auto finite = [](double v) { return v >= -limits::coordinate_max_m && v <= limits::coordinate_max_m; };
        if (node.subspace != none || node.first <= i || node.first >= nodes.size() || (node.first - 1) % 8 != 0 ||
            !finite(node.middle.x) || !finite(node.middle.y) || !finite(node.middle.z))
            return wrong(i);
        inner.push_back(node.first);
        next_child += 8;
    }
    std::sort(inner.begin(), inner.end());
    const bool each_once = std::adjacent_find(inner.begin(), inner.end()) == inner.end();
    if (!each_once || next_child != nodes.size()) return bad_input("the partition is no tree");
    if (next_subspace == 0 || next_subspace > limits::subspaces_max)
        return bad_input("the partition has " + std::to_string(next_subspace) + " subspaces");
    return Partition(std::move(nodes));
}

Stretch Partition::next(Vec3d origin, Vec3d direction, double from) const {
    for (;;) {
        Stretch stretch{none, from};
        std::uint32_t at = 0;
        while (nodes_[at].first != none) {
            // The ray passes each plane at one distance, the same for the cells of both sides; at it, it is beyond.
            std::uint32_t octant = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double middle = nodes_[at].middle[axis];
                if (direction[axis] == 0) {
                    octant |= static_cast<std::uint32_t>(origin[axis] >= middle) << axis;
                    continue;
                }
                const double passes = (middle - origin[axis]) / direction[axis];
                const bool beyond = from >= passes;
                if (!beyond) stretch.leaves = std::min(stretch.leaves, passes);
                octant |= static_cast<std::uint32_t>(beyond == (direction[axis] > 0)) << axis;
            }
            at = nodes_[at].first + octant;
        }
        stretch.subspace = nodes_[at].subspace;
        if (stretch.subspace != none || stretch.leaves == std::numeric_limits<double>::infinity()) return stretch;
        from = stretch.leaves;
    }
}

}  // namespace lumenfarm
