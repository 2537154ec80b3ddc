#include "common/octree/octree_builder.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace lumenfarm::octree_detail {
namespace {

/// A cell with up to so many times leaf_objects triangles stays whole when two of its children would hold them all.
constexpr std::uint32_t crowd_factor = 4;

/// For each set of octants eight counters of a byte, one for each octant of the set.
constexpr std::array<std::uint64_t, 256> make_byte_counters() {
    std::array<std::uint64_t, 256> table{};
    for (unsigned mask = 0; mask < 256; ++mask)
        for (unsigned octant = 0; octant < 8; ++octant)
            if (mask >> octant & 1) table[mask] |= std::uint64_t{1} << (8 * octant);
    return table;
}
constexpr std::array<std::uint64_t, 256> byte_counters = make_byte_counters();
constexpr std::uint32_t byte_counter_max = 255;

Cube octant_of(const Cube& cube, unsigned octant) {
    const float quarter = 0.5f * cube.half;
    const __m128 step = _mm_setr_ps(octant & 1 ? quarter : -quarter, octant & 2 ? quarter : -quarter,
                                    octant & 4 ? quarter : -quarter, 0);
    return {_mm_add_ps(cube.centre, step), quarter};
}

bool same_point(const float* a, const float* b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

bool lies_in(const float* point, const Cube& cube) {
    const __m128 relative = _mm_sub_ps(_mm_setr_ps(point[0], point[1], point[2], 0), cube.centre);
    return (_mm_movemask_ps(_mm_cmple_ps(absolute(relative), _mm_set1_ps(cube.half))) & 7) == 7;
}

}  // namespace

void Builder::grow(Seed seed) {
    stack_ = std::move(seed.triangles);
    top_ = stack_.size();
    nodes_.assign(1, OctreeNode{});
    grow_cell(0, seed.cube, seed.depth, {0, static_cast<std::uint32_t>(stack_.size())}, seed.budget);
    stack_ = {};
    masks_ = {};
}

void Builder::grow_cell(std::uint32_t node, const Cube& cube, std::uint32_t depth, List list, Budget budget) {
    if (!wants_split(cube, depth, list, budget)) return make_leaf(node, list);
    if (depth == rule_.stop_depth) {
        const auto first = stack_.begin() + static_cast<std::ptrdiff_t>(list.begin);
        seeds_.push_back({node, cube, depth, budget, {first, first + list.count}});
        return;
    }
    const Split split = classify(cube, list);
    if (!is_worthwhile(split, list, budget)) return make_leaf(node, list);
    const std::size_t top = top_;
    const std::array<List, 8> children = scatter(split, list);

    const auto first = static_cast<std::uint32_t>(nodes_.size());
    nodes_[node] = {first, OctreeNode::inner};
    nodes_.resize(nodes_.size() + 8);
    for (unsigned octant = 0; octant < 8; ++octant)
        grow_cell(first + octant, octant_of(cube, octant), depth + 1, children[octant],
                  share(budget, split, list, children[octant]));
    top_ = top;
}

bool Builder::wants_split(const Cube& cube, std::uint32_t depth, List list, Budget budget) const {
    return list.count > rule_.leaf_objects && depth < rule_.depth_max && budget.nodes >= 8 &&
           !meet_in_a_corner(cube, list);
}

bool Builder::meet_in_a_corner(const Cube& cube, List list) const {
    const std::uint32_t* triangles = stack_.data() + list.begin;
    for (std::size_t k = 0; k < 3; ++k) {
        const float* point = corner(triangles[0], k);
        std::uint32_t i = 1;
        while (i < list.count &&
               (same_point(point, corner(triangles[i], 0)) || same_point(point, corner(triangles[i], 1)) ||
                same_point(point, corner(triangles[i], 2))))
            ++i;
        if (i == list.count && lies_in(point, cube)) return true;
    }
    return false;
}

Builder::Split Builder::classify(const Cube& cube, List list) {
    Split split;
    if (masks_.size() < list.count) masks_.resize(list.count);
    const std::uint32_t* triangles = stack_.data() + list.begin;
    for (std::uint32_t start = 0; start < list.count; start += byte_counter_max) {
        const std::uint32_t end = std::min(list.count, start + byte_counter_max);
        std::uint64_t counters = 0;
        for (std::uint32_t i = start; i < end; ++i) {
            const unsigned mask = overlapped_octants(corner(triangles[i], 0), cube);
            masks_[i] = static_cast<std::uint8_t>(mask);
            counters += byte_counters[mask];
        }
        for (unsigned octant = 0; octant < 8; ++octant) split.counts[octant] += counters >> (8 * octant) & 255;
    }
    for (const std::uint32_t count : split.counts) {
        split.references += count;
        if (count > rule_.leaf_objects) split.crowd += count;
    }
    return split;
}

bool Builder::is_worthwhile(const Split& split, List list, Budget budget) const {
    if (split.references > list.count + budget.references) return false;
    if (list.count > std::uint64_t{crowd_factor} * rule_.leaf_objects) return true;
    return std::count(split.counts.begin(), split.counts.end(), list.count) < 2;
}

// What the split leaves is shared among the children that may split, by their triangles: no child waits for another, so
// the tree does not depend on the order of growth.
Budget Builder::share(Budget budget, const Split& split, List parent, List child) const {
    if (child.count <= rule_.leaf_objects) return {};
    const std::uint64_t references = budget.references + parent.count - split.references;
    return {(budget.nodes - 8) * child.count / split.crowd, references * child.count / split.crowd};
}

std::array<Builder::List, 8> Builder::scatter(const Split& split, List list) {
    std::array<List, 8> children;
    std::array<std::size_t, 8> place;
    std::size_t end = top_;
    for (unsigned octant = 0; octant < 8; ++octant) {
        children[octant] = {end, split.counts[octant]};
        place[octant] = end;
        end += split.counts[octant];
    }
    top_ = end;
    if (stack_.size() < end) stack_.resize(std::max(end, stack_.size() + stack_.size() / 2));
    std::uint32_t* stack = stack_.data();
    for (std::uint32_t i = 0; i < list.count; ++i)
        for (unsigned mask = masks_[i]; mask != 0; mask &= mask - 1)
            stack[place[static_cast<unsigned>(std::countr_zero(mask))]++] = stack[list.begin + i];
    return children;
}

void Builder::make_leaf(std::uint32_t node, List list) {
    const auto first = stack_.begin() + static_cast<std::ptrdiff_t>(list.begin);
    nodes_[node] = {static_cast<std::uint32_t>(items_.size()), list.count};
    items_.insert(items_.end(), first, first + list.count);
}

}  // namespace lumenfarm::octree_detail
