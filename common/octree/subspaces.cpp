#include "common/octree/subspaces.h"

#include "common/support/limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <string>
#include <tuple>
#include <utility>

namespace lumenfarm {
namespace {

/// A leaf of the cut that may be split: the heaviest first, ties to the lowest node.
struct Candidate {
    double weight = 0;
    std::uint32_t node = 0;  ///< of the cut
    OctreeCell cell;
    bool operator<(const Candidate& other) const {
        return std::tuple(weight, other.cell.node) < std::tuple(other.weight, cell.node);
    }
};

/// A triangle where it is.
class Placed {
public:
    Placed(const Scene& scene, std::uint32_t triangle) {
        const auto corner = [&](std::size_t k) { return scene.positions[scene.triangles[triangle][k]].as<double>(); };
        corner_ = corner(0);
        normal_ = cross(corner(1) - corner_, corner(2) - corner_);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low_[axis] = std::min({corner(0)[axis], corner(1)[axis], corner(2)[axis]});
            high_[axis] = std::max({corner(0)[axis], corner(1)[axis], corner(2)[axis]});
        }
    }

    /// Bit o: its bounding box comes within the margin of octant o about the middle.
    unsigned octants(Vec3d middle, double margin_m) const {
        unsigned octants = 255;
        constexpr std::array<unsigned, 3> upper{0xaa, 0xcc, 0xf0};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (high_[axis] < middle[axis] - margin_m) octants &= ~upper[axis];
            if (low_[axis] > middle[axis] + margin_m) octants &= upper[axis];
        }
        return octants;
    }

    /// Its plane comes within the margin of the box.
    bool crosses(const Box& box, double margin_m) const {
        const Vec3d half = (box.high - box.low) * 0.5;
        double reach = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) reach += (half[axis] + margin_m) * std::abs(normal_[axis]);
        return std::abs(dot(corner_ - box.low - half, normal_)) <= reach;
    }

private:
    Vec3d corner_, low_, high_;
    Vec3d normal_;  ///< not unit
};

}  // namespace

std::uint64_t Subspaces::most(const WeightedOctree& weighted) {
    const auto nodes = weighted.octree().nodes();
    const auto filled = std::count_if(nodes.begin(), nodes.end(),
                                      [](const OctreeNode& node) { return node.is_leaf() && !node.is_empty_leaf(); });
    return std::min<std::uint64_t>(static_cast<std::uint64_t>(filled), limits::subspaces_max);
}

Result<Subspaces> Subspaces::cut(const WeightedOctree& weighted, std::uint32_t count) {
    const Octree& octree = weighted.octree();
    if (count == 0) return bad_input("subspaces is 0; at least 1 is needed");
    if (const std::uint64_t most = Subspaces::most(weighted); count > most)
        return bad_input("subspaces is " + std::to_string(count) + "; the octree of this scene has " +
                         std::to_string(most) + " cells with triangles");

    Subspaces cut;
    std::vector<Partition::Node> nodes(1);
    std::priority_queue<Candidate> candidates;
    candidates.push({weighted.total_weight(), 0, Octree::root()});
    std::vector<Candidate> leaves;
    std::uint32_t filled = 1;
    while (!candidates.empty()) {
        const Candidate heaviest = candidates.top();
        candidates.pop();
        const OctreeNode& node = octree.nodes()[heaviest.cell.node];
        std::uint32_t more = 0;
        if (!node.is_leaf())
            for (std::uint32_t octant = 0; octant < 8; ++octant) more += weighted.weight(node.first + octant) > 0;
        if (node.is_leaf() || filled - 1 + more > count) {
            leaves.push_back(heaviest);
            continue;
        }
        filled += more - 1;
        const auto first = static_cast<std::uint32_t>(nodes.size());
        nodes[heaviest.node].first = first;
        nodes[heaviest.node].middle = octree.box(octree.child(heaviest.cell, 7)).low;
        nodes.resize(first + 8);
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            const OctreeCell child = octree.child(heaviest.cell, octant);
            if (const double weight = weighted.weight(child.node); weight > 0)
                candidates.push({weight, first + octant, child});
        }
    }
    std::sort(leaves.begin(), leaves.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
    for (const Candidate& leaf : leaves) {
        nodes[leaf.node].subspace = static_cast<std::uint32_t>(cut.subspaces_.size());
        cut.subspaces_.push_back({leaf.cell, octree.box(leaf.cell), leaf.weight});
    }
    cut.partition_ = Partition(std::move(nodes));
    return cut;
}

std::vector<std::vector<std::uint32_t>> Subspaces::triangles(const Scene& scene, double margin_m) const {
    std::vector<std::vector<std::uint32_t>> filed(subspaces_.size());
    const auto nodes = partition_.nodes();
    std::vector<std::uint32_t> below;  // nodes that the triangle's bounding box comes near to
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        const Placed triangle(scene, t);
        below.assign(1, 0);
        while (!below.empty()) {
            const Partition::Node& node = nodes[below.back()];
            below.pop_back();
            if (node.first == none) {
                if (node.subspace != none && triangle.crosses(subspaces_[node.subspace].box, margin_m))
                    filed[node.subspace].push_back(t);
                continue;
            }
            const unsigned octants = triangle.octants(node.middle, margin_m);
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                if (octants >> octant & 1) below.push_back(node.first + octant);
        }
    }
    return filed;
}

}  // namespace lumenfarm
