#include "common/octree/subspaces.h"

#include "common/support/ensure.h"
#include "common/support/limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <string>
#include <utility>

namespace lumenfarm {
namespace {

/// What of the work lies below a plane, as a fraction. Of two boxes that touch in it, the flat one is above.
double fraction_below(const Box& box, std::size_t axis, double plane) {
    const double length = box.high[axis] - box.low[axis];
    if (length <= 0) return box.low[axis] < plane ? 1 : 0;
    return std::clamp((plane - box.low[axis]) / length, 0.0, 1.0);
}

/// A cell that is to have so many of the subspaces.
struct Cell {
    std::uint32_t node = 0;  ///< of the partition
    Box box;
    std::uint32_t count = 0;
    std::vector<SpreadWork> work;
};

double sum_of(const std::vector<SpreadWork>& work) {
    double sum = 0;
    for (const SpreadWork& each : work) sum += each.work;
    return sum;
}

/// Where about this much work lies below, by bisection. What lies on one side for good is looked at no more.
double plane_with(double wanted, const Cell& cell, std::size_t axis) {
    constexpr int halvings = 60;
    double low = cell.box.low[axis], high = cell.box.high[axis];
    double below = 0;  // of what lies below `low`
    std::vector<SpreadWork> between = cell.work;
    for (int i = 0; i < halvings && !between.empty(); ++i) {
        const double plane = 0.5 * (low + high);
        double more = 0;
        for (const SpreadWork& each : between) more += each.work * fraction_below(each.box, axis, plane);
        const auto is_below = [&](const SpreadWork& each) { return fraction_below(each.box, axis, plane) >= 1; };
        if (below + more < wanted) {
            low = plane;
            for (const SpreadWork& each : between)
                if (is_below(each)) below += each.work;
            std::erase_if(between, is_below);
        } else {
            high = plane;
            std::erase_if(between, [&](const SpreadWork& each) { return fraction_below(each.box, axis, plane) <= 0; });
        }
    }
    return 0.5 * (low + high);
}

/// The parts of the work below and above the plane.
std::array<std::vector<SpreadWork>, 2> parted(std::vector<SpreadWork> work, std::size_t axis, double plane) {
    std::array<std::vector<SpreadWork>, 2> halves;
    for (const SpreadWork& each : work) {
        const double below = fraction_below(each.box, axis, plane);
        std::array<SpreadWork, 2> parts{each, each};
        if (below > 0 && below < 1) parts[0].box.high[axis] = parts[1].box.low[axis] = plane;
        parts[0].work *= below;
        parts[1].work *= 1 - below;
        for (std::size_t half = 0; half < 2; ++half)
            if (parts[half].work > 0) halves[half].push_back(parts[half]);
    }
    return halves;
}

/// The axes, that of the longest edge first.
std::array<std::size_t, 3> by_length(const Box& box) {
    const Vec3d size = box.high - box.low;
    std::array<std::size_t, 3> axes{0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
    return axes;
}

struct Plane {
    std::size_t axis = 0;
    double plane_m = 0;
};

/// The plane, or, where it runs along flat work, those next to it that do not: rays meet such work now on this side of
/// it, now on that.
std::vector<double> clear_planes(double plane, const Cell& cell, std::size_t axis) {
    const double margin = (cell.box.high[axis] - cell.box.low[axis]) / 4096;
    double low = plane, high = plane;
    bool clear = true;
    for (const SpreadWork& each : cell.work) {
        const Vec3d size = each.box.high - each.box.low;
        const bool is_flat = size[axis] <= margin && std::max({size.x, size.y, size.z}) > 4 * margin;
        if (!is_flat || each.box.high[axis] < plane - margin || each.box.low[axis] > plane + margin) continue;
        low = std::min(low, each.box.low[axis]);
        high = std::max(high, each.box.high[axis]);
        clear = false;
    }
    std::vector<double> planes;
    for (const double beside : {low - margin, high + margin})
        if (!clear && cell.box.low[axis] < beside && beside < cell.box.high[axis]) planes.push_back(beside);
    return planes.empty() ? std::vector<double>{plane} : planes;
}

/// The first that parts the work well enough, or else the one that does it best: flat work can't be parted across it.
Plane best_plane(const Cell& cell, double wanted) {
    constexpr double tolerated = 0.02;  ///< of the work on the wrong side
    const double whole = sum_of(cell.work);
    Plane best;
    double least_error = std::numeric_limits<double>::infinity();
    for (const std::size_t axis : by_length(cell.box)) {
        for (const double plane : clear_planes(plane_with(wanted, cell, axis), cell, axis)) {
            double below = 0;
            for (const SpreadWork& each : cell.work) below += each.work * fraction_below(each.box, axis, plane);
            const double error = std::abs(below - wanted);
            if (error < least_error) best = {axis, plane};
            least_error = std::min(least_error, error);
        }
        if (least_error <= tolerated * whole) break;
    }
    return best;
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

    return cut(octree.box(Octree::root()), planned_work(weighted), count);
}

Subspaces Subspaces::cut(const Box& root, std::vector<SpreadWork> work, std::uint32_t count) {
    ensure(count > 0 && count <= limits::subspaces_max, "a scene is cut into some subspaces");
    Subspaces cut;
    cut.root_ = root;
    std::vector<Partition::Node> nodes(1);
    std::deque<Cell> cells;
    cells.push_back({0, root, count, std::move(work)});
    for (; !cells.empty(); cells.pop_front()) {
        Cell& cell = cells.front();
        if (cell.count == 1) {
            nodes[cell.node].which = static_cast<std::uint32_t>(cut.subspaces_.size());
            cut.subspaces_.push_back({cell.box, sum_of(cell.work)});
            continue;
        }
        const std::uint32_t lower_count = cell.count / 2;
        const double share = static_cast<double>(lower_count) / cell.count;
        const auto [axis, plane] = best_plane(cell, share * sum_of(cell.work));
        auto halves = parted(std::move(cell.work), axis, plane);
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

Subspaces Subspaces::of(const Box& root, Partition partition) {
    Subspaces cut;
    cut.root_ = root;
    cut.subspaces_.resize(partition.subspaces());
    std::vector<Box> boxes(partition.nodes().size());
    boxes.front() = root;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Partition::Node& node = partition.nodes()[i];
        if (node.is_leaf()) {
            cut.subspaces_[node.which].box = boxes[i];
            continue;
        }
        boxes[node.first] = boxes[node.first + 1] = boxes[i];
        boxes[node.first].high[node.which] = boxes[node.first + 1].low[node.which] = node.plane_m;
    }
    cut.partition_ = std::move(partition);
    return cut;
}

std::vector<double> Subspaces::shares(std::span<const SpreadWork> work) const {
    std::vector<double> shares(subspaces_.size());
    for (const SpreadWork& each : work) shares[partition_.of((each.box.low + each.box.high) * 0.5)] += each.work;
    return shares;
}

std::vector<SpreadWork> planned_work(const WeightedOctree& weighted) {
    std::vector<SpreadWork> work;
    weighted.octree().for_each_cell([&](const OctreeCell& cell) {
        if (weighted.octree().nodes()[cell.node].is_leaf() && weighted.weight(cell.node) > 0)
            work.push_back({weighted.octree().box(cell), weighted.weight(cell.node)});
    });
    return work;
}

double imbalance(std::span<const double> shares) {
    double most = 0, sum = 0;
    for (const double share : shares) {
        most = std::max(most, share);
        sum += share;
    }
    return sum > 0 ? most * static_cast<double>(shares.size()) / sum : 1;
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
