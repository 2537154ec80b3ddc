#include "common/octree/subspaces.h"

#include "common/support/limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <string>
#include <utility>

namespace lumenfarm {
namespace {

/// A leaf of the octree, or what of it lies in a cell.
struct Filled {
    Box box;
    double weight = 0;

    double length(std::size_t axis) const { return box.high[axis] - box.low[axis]; }
    double weight_below(std::size_t axis, double plane) const {
        return weight * std::clamp((plane - box.low[axis]) / length(axis), 0.0, 1.0);
    }
};

/// A cell that is to have so many of the subspaces.
struct Cell {
    std::uint32_t node = 0;  ///< of the partition
    Box box;
    std::uint32_t count = 0;
    std::vector<Filled> filled;
};

double weight_of(const std::vector<Filled>& filled) {
    double weight = 0;
    for (const Filled& leaf : filled) weight += leaf.weight;
    return weight;
}

std::vector<Filled> filled_leaves(const WeightedOctree& weighted) {
    std::vector<Filled> filled;
    weighted.octree().for_each_cell([&](const OctreeCell& cell) {
        if (weighted.octree().nodes()[cell.node].is_leaf() && weighted.weight(cell.node) > 0)
            filled.push_back({weighted.octree().box(cell), weighted.weight(cell.node)});
    });
    return filled;
}

/// Where about this weight lies below, by bisection. What lies on one side for good is looked at no more.
double plane_with(double weight, const Cell& cell, std::size_t axis) {
    constexpr int halvings = 60;
    double low = cell.box.low[axis], high = cell.box.high[axis];
    double below = 0;  // of what lies below `low`
    std::vector<Filled> between = cell.filled;
    for (int i = 0; i < halvings && !between.empty(); ++i) {
        const double plane = 0.5 * (low + high);
        double more = 0;
        for (const Filled& leaf : between) more += leaf.weight_below(axis, plane);
        if (below + more < weight) {
            low = plane;
            for (const Filled& leaf : between)
                if (leaf.box.high[axis] <= plane) below += leaf.weight;
            std::erase_if(between, [&](const Filled& leaf) { return leaf.box.high[axis] <= plane; });
        } else {
            high = plane;
            std::erase_if(between, [&](const Filled& leaf) { return leaf.box.low[axis] >= plane; });
        }
    }
    return 0.5 * (low + high);
}

/// The parts of the leaves below and above the plane.
std::array<std::vector<Filled>, 2> parted(std::vector<Filled> filled, std::size_t axis, double plane) {
    std::array<std::vector<Filled>, 2> halves;
    for (const Filled& leaf : filled) {
        std::array<Filled, 2> parts{leaf, leaf};
        parts[0].box.high[axis] = std::min(plane, leaf.box.high[axis]);
        parts[1].box.low[axis] = std::max(plane, leaf.box.low[axis]);
        for (std::size_t half = 0; half < 2; ++half) {
            parts[half].weight = leaf.weight * parts[half].length(axis) / leaf.length(axis);
            if (parts[half].length(axis) > 0 && parts[half].weight > 0) halves[half].push_back(parts[half]);
        }
    }
    return halves;
}

std::size_t longest_edge(const Box& box) {
    const Vec3d size = box.high - box.low;
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

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

    /// Its bounding box comes within the margin of the side of the plane.
    bool is_below(std::size_t axis, double plane, double margin_m) const { return low_[axis] <= plane + margin_m; }
    bool is_above(std::size_t axis, double plane, double margin_m) const { return high_[axis] >= plane - margin_m; }

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
    std::deque<Cell> cells;
    cells.push_back({0, octree.box(Octree::root()), count, filled_leaves(weighted)});
    for (; !cells.empty(); cells.pop_front()) {
        Cell& cell = cells.front();
        if (cell.count == 1) {
            nodes[cell.node].which = static_cast<std::uint32_t>(cut.subspaces_.size());
            cut.subspaces_.push_back({cell.box, weight_of(cell.filled)});
            continue;
        }
        const std::size_t axis = longest_edge(cell.box);
        const std::uint32_t lower_count = cell.count / 2;
        const double share = static_cast<double>(lower_count) / cell.count;
        const double plane = plane_with(share * weight_of(cell.filled), cell, axis);
        auto halves = parted(std::move(cell.filled), axis, plane);
        Cell lower{static_cast<std::uint32_t>(nodes.size()), cell.box, lower_count, std::move(halves[0])};
        Cell upper{lower.node + 1, cell.box, cell.count - lower_count, std::move(halves[1])};
        lower.box.high[axis] = upper.box.low[axis] = plane;
        nodes[cell.node] = {plane, lower.node, static_cast<std::uint32_t>(axis)};
        nodes.resize(nodes.size() + 2);
        cells.push_back(std::move(lower));
        cells.push_back(std::move(upper));
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
            if (node.is_leaf()) {
                if (triangle.crosses(subspaces_[node.which].box, margin_m)) filed[node.which].push_back(t);
                continue;
            }
            if (triangle.is_below(node.which, node.plane_m, margin_m)) below.push_back(node.first);
            if (triangle.is_above(node.which, node.plane_m, margin_m)) below.push_back(node.first + 1);
        }
    }
    return filed;
}

}  // namespace lumenfarm
