#include "common/octree/weighted_octree.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <utility>

namespace lumenfarm {
namespace {

bool holds(const Box& outer, const Box& inner) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (inner.low[axis] < outer.low[axis] || inner.high[axis] > outer.high[axis]) return false;
    return true;
}

bool holds_triangles(const Octree& octree, std::uint32_t node) {
    const OctreeNode& n = octree.nodes()[node];
    if (n.is_leaf()) return !n.is_empty_leaf();
    for (std::uint32_t octant = 0; octant < 8; ++octant)
        if (holds_triangles(octree, n.first + octant)) return true;
    return false;
}

Box extend(Box box, Vec3d point) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::min(box.low[axis], point[axis]);
        box.high[axis] = std::max(box.high[axis], point[axis]);
    }
    return box;
}

}  // namespace

WeightedOctree::WeightedOctree(Octree octree, std::span<const LightPlace> lights)
    : octree_(std::move(octree)), weights_(octree_.nodes().size()) {
    std::vector<double> added(weights_.size());
    for (const LightPlace& light : lights) {
        const OctreeCell cell = light_cell(octree_, light.extent);
        light_cells_.push_back(cell);
        added_weights_.push_back(light.weight);
        added[cell.node] += light.weight;
    }
    weigh_leaves();
    sum_up();
    hand_down(added);
    sum_up();
}

void WeightedOctree::weigh_leaves() {
    for (std::size_t i = 0; i < weights_.size(); ++i) weights_[i] = octree_.nodes()[i].is_empty_leaf() ? 0 : 1;
}

// Parents stand before their children, so one pass in order reaches every leaf. A light in a scene without triangles
// has no leaf to go to.
void WeightedOctree::hand_down(std::vector<double>& added) {
    for (std::size_t i = 0; i < weights_.size(); ++i) {
        const OctreeNode& node = octree_.nodes()[i];
        if (added[i] == 0 || weights_[i] == 0) continue;
        if (node.is_leaf()) {
            weights_[i] += added[i];
            continue;
        }
        const auto first = weights_.begin() + node.first;
        const auto filled = 8 - std::count(first, first + 8, 0.0);
        for (std::uint32_t child = node.first; child < node.first + 8; ++child)
            if (weights_[child] != 0) added[child] += added[i] / static_cast<double>(filled);
    }
}

void WeightedOctree::sum_up() {
    for (std::size_t i = weights_.size(); i-- > 0;) {
        const OctreeNode& node = octree_.nodes()[i];
        if (node.is_leaf()) continue;
        weights_[i] = 0;
        for (std::uint32_t octant = 0; octant < 8; ++octant) weights_[i] += weights_[node.first + octant];
    }
}

WeightedOctree make_weighted_octree(const Scene& scene, const OctreeOptions& options,
                                    std::span<const double> light_shares, double light_weight) {
    ensure(light_shares.size() == scene.lights.size(), "each light has a share of the flux");
    Octree octree = Octree::make(scene, options);
    const auto filled = static_cast<double>(filled_leaves(octree, Octree::root().node));
    std::vector<LightPlace> places;
    for (std::size_t l = 0; l < scene.lights.size(); ++l)
        places.push_back({light_extent(scene, scene.lights[l]), light_shares[l] * light_weight * filled});
    return WeightedOctree(std::move(octree), places);
}

Box light_extent(const Scene& scene, const Light& light) {
    if (light.kind != LightKind::surface) return {light.position, light.position};
    const Surface& surface = scene.surfaces[light.surface];
    Box box;
    for (std::uint32_t i = 0; i < surface.triangle_count; ++i)
        for (const std::uint32_t vertex : scene.triangles[surface.first_triangle + i])
            box = extend(box, scene.positions[vertex].as<double>());
    return box;
}

OctreeCell light_cell(const Octree& octree, const Box& extent) {
    const OctreeCell root = Octree::root();
    if (octree.nodes()[root.node].is_leaf()) return root;
    // from the last octant, as the upper of two touching cells has the point (leaf_of)
    for (std::uint32_t octant = 8; octant-- > 0;) {
        const OctreeCell cell = octree.child(root, octant);
        if (holds(octree.box(cell), extent)) return holds_triangles(octree, cell.node) ? cell : root;
    }
    return root;
}

std::uint64_t filled_leaves(const Octree& octree, std::uint32_t node) {
    const OctreeNode& n = octree.nodes()[node];
    if (n.is_leaf()) return n.is_empty_leaf() ? 0 : 1;
    std::uint64_t leaves = 0;
    for (std::uint32_t octant = 0; octant < 8; ++octant) leaves += filled_leaves(octree, n.first + octant);
    return leaves;
}

OctreeSummary summarize(const Scene& scene, const WeightedOctree& weighted) {
    const Octree& octree = weighted.octree();
    OctreeSummary summary;
    summary.triangles = scene.triangles.size();
    summary.nodes = octree.nodes().size();
    summary.root = octree.box(Octree::root());
    octree.for_each_cell([&](const OctreeCell& cell) {
        const OctreeNode& node = octree.nodes()[cell.node];
        if (!node.is_leaf()) return;
        ++summary.leaves;
        summary.empty_leaves += node.is_empty_leaf();
        summary.references += node.count;
        summary.fullest_leaf = std::max(summary.fullest_leaf, node.count);
        summary.depth = std::max(summary.depth, cell.depth);
    });
    summary.total_weight = weighted.total_weight();
    summary.light_weight = summary.total_weight - static_cast<double>(summary.leaves - summary.empty_leaves);
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const OctreeCell cell = weighted.light_cells()[l];
        summary.lights.push_back(
            {scene.lights[l].name, octree.box(cell), cell.depth, weighted.added_weight(l), weighted.weight(cell.node)});
    }
    return summary;
}

}  // namespace lumenfarm
