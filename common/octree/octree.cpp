#include "common/octree/octree.h"

#include "common/octree/octree_builder.h"
#include "common/support/ensure.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numeric>
#include <thread>
#include <utility>

namespace lumenfarm {
namespace {

using octree_detail::Budget;
using octree_detail::Builder;
using octree_detail::Cube;
using octree_detail::Part;
using octree_detail::Seed;
using octree_detail::SplitRule;

constexpr std::uint64_t nodes_per_triangle = 16;  ///< of the automatic node limit
constexpr std::uint64_t references_per_triangle = 32;
constexpr std::uint64_t at_least = 4'096;    ///< nodes and references of small scenes
constexpr std::uint32_t seeds_wanted = 256;  ///< a cell with fewer than 1 / 256 of the triangles is grown by itself
constexpr std::uint32_t seed_count_min = 1'024;
constexpr std::uint32_t float_digits = 24;
/// What a mesh usually takes, for each triangle; more is allocated when it is needed.
constexpr std::uint64_t usual_nodes = 6, usual_items = 10;

constexpr Vec3d low_offset{19.0 / 64, 27.0 / 64, 37.0 / 64};
constexpr int low_offset_digits = 6;

/// The root cube on the grid of a power of two, so that the bounds and centres of all cells are exact floats when they
/// are measured in `unit_m`. Walls and floors like round numbers and middles; were they also bounds of cells, each of
/// their triangles would stand in the cells of both sides. So the side is an odd number of units (11 to 19), the low
/// corner lies off the whole numbers, and round planes are bounds of cells only by chance.
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
    const double side = std::ceil(largest / lattice.unit_m) + 2;
    lattice.side = std::fmod(side, 2) == 1 ? side : side + 1;
    double reach = lattice.side;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double middle = 0.5 * (box.low[axis] + box.high[axis]) / lattice.unit_m;
        lattice.low[axis] = std::floor(middle - 0.5 * lattice.side) + low_offset[axis];
        reach = std::max({reach, std::abs(lattice.low[axis]), std::abs(lattice.low[axis] + lattice.side)});
    }
    // a centre at depth d is at most `reach` and a multiple of 2^-(d+1) units, of 2^-6 near the root
    const int digits = static_cast<int>(float_digits) - 1 - std::ilogb(reach);
    lattice.depth_max = static_cast<std::uint32_t>(digits < low_offset_digits ? 0 : digits - 1);
    return lattice;
}

std::unique_ptr<float[]> gather_corners(const Scene& scene, double unit_m) {
    const auto scale = static_cast<float>(1 / unit_m);
    auto corners = std::make_unique_for_overwrite<float[]>(9 * scene.triangles.size() + 1);
    float* next = corners.get();
    for (const Triangle& triangle : scene.triangles)
        for (const std::uint32_t vertex : triangle) {
            const Vec3f p = scene.positions[vertex] * scale;
            *next++ = p.x, *next++ = p.y, *next++ = p.z;
        }
    *next = 0;
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

/// Of `usual` for each triangle: room that costs nothing until it is used.
void reserve(Builder& builder, std::uint64_t triangles) {
    builder.nodes().reserve(std::min(usual_nodes * triangles, limits::octree_nodes_max));
    builder.items().reserve(std::min(usual_items * triangles, limits::octree_references_max));
}

/// Appends a part whose root stands at `node` of the whole.
void append_part(Builder& whole, std::uint32_t node, Builder& grower, const Part& part) {
    const std::size_t node_shift = whole.nodes().size() - part.node_begin;
    const std::size_t item_shift = whole.items().size() - part.item_begin;
    const auto moved = [&](OctreeNode n) {
        return OctreeNode{static_cast<std::uint32_t>(n.first + (n.is_leaf() ? item_shift : node_shift)), n.count};
    };
    whole.nodes()[node] = moved(part.root);
    for (std::size_t i = part.node_begin; i < part.node_end; ++i) whole.nodes().push_back(moved(grower.nodes()[i]));
    const auto items = grower.items().begin();
    whole.items().insert(whole.items().end(), items + static_cast<std::ptrdiff_t>(part.item_begin),
                         items + static_cast<std::ptrdiff_t>(part.item_end));
}

/// Grows the seeds in `whole` itself, one after the other.
void grow_seeds(Builder& whole, std::vector<Seed> seeds) {
    for (Seed& seed : seeds) {
        const std::uint32_t node = seed.node;
        const Part part = whole.grow(std::move(seed));
        whole.nodes()[node] = part.root;
    }
}

/// Grows the seeds on several threads, each in a builder of its own, and puts the parts together in the order of the
/// seeds: the same as grow_seeds, whoever grew which.
void grow_seeds(Builder& whole, std::vector<Seed> seeds, const Builder& empty, std::uint32_t threads,
                std::uint64_t triangles) {
    struct Grown {
        std::uint32_t node = 0;
        std::uint32_t thread = 0;
        Part part;
    };
    std::vector<Grown> grown(seeds.size());
    std::vector<Builder> growers(threads, empty);
    std::atomic<std::size_t> next = 0;
    const auto work = [&](std::uint32_t thread) {
        reserve(growers[thread], triangles / threads);
        for (std::size_t i = next++; i < seeds.size(); i = next++) {
            grown[i] = {seeds[i].node, thread, {}};
            grown[i].part = growers[thread].grow(std::move(seeds[i]));
        }
    };
    {
        std::vector<std::jthread> helpers;
        for (std::uint32_t thread = 1; thread < threads; ++thread) helpers.emplace_back(work, thread);
        work(0);
    }
    for (const Grown& g : grown) append_part(whole, g.node, growers[g.thread], g.part);
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

    const std::uint64_t triangles = scene.triangles.size();
    const std::unique_ptr<float[]> corners = gather_corners(scene, lattice.unit_m);
    const SplitRule rule{options.leaf_objects, std::min(options.depth_max, lattice.depth_max), 0};
    const Builder empty(corners.get(), rule);
    Builder whole = empty;
    reserve(whole, triangles);
    whole.nodes().resize(1);
    whole.set_seed_count(static_cast<std::uint32_t>(std::max<std::uint64_t>(seed_count_min, triangles / seeds_wanted)));
    whole.nodes()[0] = whole.grow(root_seed(lattice, triangles, root_budget(triangles, options.nodes_max))).root;
    whole.set_seed_count(0);
    std::vector<Seed> seeds = std::exchange(whole.seeds(), {});
    if (options.threads > 1)
        grow_seeds(whole, std::move(seeds), empty, options.threads, triangles);
    else
        grow_seeds(whole, std::move(seeds));
    octree.nodes_ = std::move(whole.nodes());
    octree.items_ = std::move(whole.items());
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
