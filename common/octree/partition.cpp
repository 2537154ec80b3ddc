#include "common/octree/partition.h"

#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace lumenfarm {

Result<Partition> Partition::check(std::vector<Node> nodes) {
    std::uint32_t next_subspace = 0;
    // of inner nodes; were two the same, the nodes would not all be below the root once
    std::vector<std::uint32_t> children;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
        const Node& node = nodes[i];
        const bool possible =
            std::abs(node.plane_m) <= 2 * limits::coordinate_max_m;  // the root is larger than a scene
        const bool good = node.is_leaf() ? node.which == next_subspace++
                                         : possible && node.which < 3 && node.first > i && node.first % 2 == 1 &&
                                               node.first + 1 < nodes.size();
        if (!good) return bad_input("node " + std::to_string(i) + " of the partition is out of place");
        if (!node.is_leaf()) children.push_back(node.first);
    }
    std::sort(children.begin(), children.end());
    const bool each_once = std::adjacent_find(children.begin(), children.end()) == children.end();
    if (!each_once || 2 * children.size() + 1 != nodes.size()) return bad_input("the partition is no tree");
    return Partition(std::move(nodes));
}

Stretch Partition::at(Vec3d origin, Vec3d direction, double from) const {
    Stretch stretch{none, from};
    const Node* node = nodes_.data();
    while (!node->is_leaf()) {
        const std::uint32_t axis = node->which;
        bool upper = origin[axis] >= node->plane_m;
        if (direction[axis] != 0) {
            // The ray passes the plane at one distance, the same for the cells of both sides; at it, it is beyond.
            const double passes = (node->plane_m - origin[axis]) / direction[axis];
            const bool beyond = from >= passes;
            if (!beyond) stretch.leaves = std::min(stretch.leaves, passes);
            upper = beyond == (direction[axis] > 0);
        }
        node = &nodes_[node->first + upper];
    }
    stretch.subspace = node->which;
    return stretch;
}

std::uint32_t Partition::of(Vec3d point) const {
    const Node* node = nodes_.data();
    while (!node->is_leaf()) node = &nodes_[node->first + (point[node->which] >= node->plane_m)];
    return node->which;
}

}  // namespace lumenfarm
