#include "common/octree/octree.h"

#include "common/octree/octree_builder.h"
#include "common/support/ensure.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <thread>

namespace lumenfarm {
namespace {

using octree_detail::Budget;
using octree_detail::Builder;
using octree_detail::Cube;
using octree_detail::Seed;
using octree_detail::SplitRule;

constexpr std::uint64_t nodes_per_triangle = 16;  ///< of the automatic node limit
constexpr std::uint64_t references_per_triangle = 32;
constexpr std::uint64_t at_least = 4'096;  ///< nodes and references of small scenes
constexpr std::uint32_t seed_depth = 3;    ///< up to 512 parts are grown by themselves
constexpr std::uint32_t float_digits = 24;

/// The root cube on the grid of a power of two, so that the bounds and centres of all cells are exact floats when they
/// are measured in `unit_m`: the side is 10 to 18 units, the low corner a whole number of them.
struct Lattice {
    double unit_m = 1;
    Vec3d low;  ///< [units]
    double side = 0;
    std::uint32_t depth_max = 0;  ///< of exact centres
};

Lattice make_lattice(const Box& box) {
    Lattice lattice;
    const Vec3d extent = box.high - box.low;
    const double largest = std::max({extent.x, extent.y, extent.z});
    lattice.unit_m = std::exp2(std::ilogb(std::max(largest, 1e-30)) - 3);
    lattice.side = std::ceil(largest / lattice.unit_m) + 2;
    double reach = lattice.side;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double middle = 0.5 * (box.low[axis] + box.high[axis]) / lattice.unit_m;
        lattice.low[axis] = std::floor(middle - 0.5 * lattice.side + 0.5);
        reach = std::max({reach, std::abs(lattice.low[axis]), std::abs(lattice.low[axis] + lattice.side)});
    }
    // a centre at depth d is a multiple of 2^-(d+1) units and at most `reach`; octants' centres one digit more
    const int digits = static_cast<int>(float_digits) - 3 - std::ilogb(reach);
    lattice.depth_max = static_cast<std::uint32_t>(std::max(digits, 0));
    return lattice;
}

std::vector<float> gather_corners(const Scene& scene, double unit_m) {
    const auto scale = static_cast<float>(1 / unit_m);
    std::vector<float> corners;
    corners.reserve(9 * scene.triangles.size() + 1);
    for (const Triangle& triangle : scene.triangles)
        for (const std::uint32_t vertex : triangle) {
            const Vec3f p = scene.positions[vertex] * scale;
            corners.insert(corners.end(), {p.x, p.y, p.z});
        }
    corners.push_back(0);
    return corners;
}

Budget root_budget(std::uint64_t triangles, std::uint64_t nodes_max) {
    const std::uint64_t automatic = std::min(at_least + nodes_per_triangle * triangles, limits::octree_nodes_max);
    const std::uint64_t references =
        std::min(at_least + references_per_triangle * triangles, limits::octree_references_max);
    return {(nodes_max ? nodes_max : automatic) - 1, references - std::min(references, triangles)};
}

Seed root_seed(const Lattice& lattice, std::size_t triangles, Budget budget) {
    Seed seed;
    const Vec3f centre = (lattice.low + Vec3d{1, 1, 1} * (0.5 * lattice.side)).as<float>();
    seed.cube = {_mm_setr_ps(centre.x, centre.y, centre.z, 0), static_cast<float>(0.5 * lattice.side)};
    seed.budget = budget;
    seed.triangles.resize(triangles);
    std::iota(seed.triangles.begin(), seed.triangles.end(), 0u);
    return seed;
}

/// Grows each seed by itself, on several threads; what comes out does not depend on who grew which.
std::vector<Builder> grow_parts(std::span<const float> corners, SplitRule rule, std::vector<Seed>& seeds,
                                std::uint32_t threads) {
    std::vector<Builder> parts(seeds.size(), Builder(corners, rule));
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        for (std::size_t i = next++; i < seeds.size(); i = next++) parts[i].grow(std::move(seeds[i]));
    };
    {
        std::vector<std::jthread> helpers;
        for (std::uint32_t i = 1; i < threads; ++i) helpers.emplace_back(work);
        work();
    }
    return parts;
}

/// Appends a part whose root stands at `node` of the whole.
void append_part(std::vector<OctreeNode>& nodes, std::vector<std::uint32_t>& items, std::uint32_t node, Builder& part) {
    const auto node_shift = static_cast<std::uint32_t>(nodes.size() - 1);  // the part's root is not repeated
    const auto item_shift = static_cast<std::uint32_t>(items.size());
    const auto moved = [&](OctreeNode n) {
        return OctreeNode{n.first + (n.is_leaf() ? item_shift : node_shift), n.count};
    };
    nodes[node] = moved(part.nodes()[0]);
    for (std::size_t i = 1; i < part.nodes().size(); ++i) nodes.push_back(moved(part.nodes()[i]));
    items.insert(items.end(), part.items().begin(), part.items().end());
    part.nodes() = {};
    part.items() = {};
}

}  // namespace

Octree Octree::make(const Scene& scene, const OctreeOptions& options) {
    ensure(options.leaf_objects > 0 && options.depth_max <= limits::octree_depth_max &&
               options.nodes_max <= limits::octree_nodes_max && options.threads <= limits::octree_threads_max,
           "octree options are within their limits");
    Octree octree;
    if (scene.triangles.empty()) return octree;
    const Lattice lattice = make_lattice(bounding_box(scene));
    octree.low_m_ = lattice.low * lattice.unit_m;
    octree.side_m_ = lattice.side * lattice.unit_m;

    const std::vector<float> corners = gather_corners(scene, lattice.unit_m);
    SplitRule rule{options.leaf_objects, std::min(options.depth_max, lattice.depth_max), seed_depth};
    Builder top(corners, rule);
    top.grow(root_seed(lattice, scene.triangles.size(), root_budget(scene.triangles.size(), options.nodes_max)));
    rule.stop_depth = none;
    std::vector<Seed>& seeds = top.seeds();
    std::vector<std::uint32_t> places;
    for (const Seed& seed : seeds) places.push_back(seed.node);
    std::vector<Builder> parts = grow_parts(corners, rule, seeds, options.threads);

    std::size_t node_count = top.nodes().size(), item_count = top.items().size();
    for (Builder& part : parts) node_count += part.nodes().size() - 1, item_count += part.items().size();
    octree.nodes_ = std::move(top.nodes());
    octree.items_ = std::move(top.items());
    octree.nodes_.reserve(node_count);
    octree.items_.reserve(item_count);
    for (std::size_t i = 0; i < parts.size(); ++i) append_part(octree.nodes_, octree.items_, places[i], parts[i]);
    return octree;
}

Box Octree::box(const OctreeCell& cell) const {
    const double side = std::ldexp(side_m_, -static_cast<int>(cell.depth));
    const Vec3d low = low_m_ + Vec3d{cell.x * side, cell.y * side, cell.z * side};
    return {low, low + Vec3d{side, side, side}};
}

std::uint32_t Octree::leaf_of(Vec3d point) const {
    const Box all = box(root());
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(point[axis] >= all.low[axis] && point[axis] <= all.high[axis])) return none;
    OctreeCell cell = root();
    while (!nodes_[cell.node].is_leaf()) {
        const Vec3d middle = box(child(cell, 7)).low;
        cell = child(cell, (point.x >= middle.x) | (point.y >= middle.y) << 1 | (point.z >= middle.z) << 2);
    }
    return cell.node;
}

}  // namespace lumenfarm
