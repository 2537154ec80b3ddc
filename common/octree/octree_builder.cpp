#include "common/octree/octree_builder.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace lumenfarm::octree_detail {
namespace {

/// A cell with up to so many times leaf_objects triangles stays whole when each child that is not empty would hold them
/// all.
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

Part Builder::grow(Seed seed) {
    if (stack_.size() < seed.triangles.size()) stack_.resize(seed.triangles.size());
    std::copy(seed.triangles.begin(), seed.triangles.end(), stack_.begin());
    top_ = seed.triangles.size();
    Part part;
    part.node_begin = nodes_.size();
    part.item_begin = items_.size();
    part.root = grow_cell(seed.node, seed.cube, seed.depth, {0, static_cast<std::uint32_t>(top_)}, seed.budget);
    part.node_end = nodes_.size();
    part.item_end = items_.size();
    return part;
}

OctreeNode Builder::grow_cell(std::uint32_t node, const Cube& cube, std::uint32_t depth, List list, Budget budget) {
    if (!wants_split(cube, depth, list, budget)) return make_leaf(list);
    if (list.count <= rule_.seed_count) {
        keep_seed(node, cube, depth, list, budget);
        return {};
    }
    const Split split = classify(cube, list);
    if (!is_worthwhile(split, list, budget)) return make_leaf(list);
    const std::size_t top = top_;
    const auto first = static_cast<std::uint32_t>(nodes_.size());
    nodes_.resize(first + 8);
    const std::array<List, 8> children = scatter(split, list, nodes_.data() + first);
    for (unsigned octant = 0; octant < 8; ++octant) {
        const List child = children[octant];
        if (child.count <= rule_.leaf_objects) continue;  // scatter has made the leaf
        const OctreeNode grown =
            grow_cell(first + octant, octant_of(cube, octant), depth + 1, child, share(budget, split, list, child));
        nodes_[first + octant] = grown;
    }
    top_ = top;
    return {first, OctreeNode::inner};
}

void Builder::keep_seed(std::uint32_t node, const Cube& cube, std::uint32_t depth, List list, Budget budget) {
    const auto first = stack_.begin() + static_cast<std::ptrdiff_t>(list.begin);
    seeds_.push_back({node, cube, depth, budget, {first, first + list.count}});
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
    std::uint8_t* masks = masks_.data();
    for (std::uint32_t start = 0; start < list.count; start += byte_counter_max) {
        const std::uint32_t end = std::min(list.count, start + byte_counter_max);
        std::uint64_t counters = 0;
        for (std::uint32_t i = start; i < end; ++i) {
            const unsigned mask = overlapped_octants(corner(triangles[i], 0), cube);
            masks[i] = static_cast<std::uint8_t>(mask);
            counters += byte_counters[mask];
        }
        for (unsigned octant = 0; octant < 8; ++octant)
            split.counts[octant] += static_cast<std::uint32_t>(counters >> (8 * octant) & 255);
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
    const auto empty = std::count(split.counts.begin(), split.counts.end(), 0u);
    return split.references < static_cast<std::uint64_t>(8 - empty) * list.count || empty == 7;
}

// What the split leaves is shared among the children that may split, by their triangles: no child waits for another, so
// the tree does not depend on the order of growth.
Budget Builder::share(Budget budget, const Split& split, List parent, List child) const {
    if (child.count <= rule_.leaf_objects) return {};
    const std::uint64_t references = budget.references + parent.count - split.references;
    return {(budget.nodes - 8) * child.count / split.crowd, references * child.count / split.crowd};
}

// Lists of leaves go straight to the items, those of children that may split onto the stack.
std::array<Builder::List, 8> Builder::scatter(const Split& split, List list, OctreeNode* children) {
    std::array<List, 8> lists;
    std::size_t item_end = items_.size();
    for (unsigned octant = 0; octant < 8; ++octant) {
        const std::uint32_t count = split.counts[octant];
        if (count <= rule_.leaf_objects) {
            children[octant] = {static_cast<std::uint32_t>(item_end), count};
            lists[octant] = {item_end, count};
            item_end += count;
        } else {
            lists[octant] = {top_, count};
            top_ += count;
        }
    }
    items_.resize(item_end);
    if (stack_.size() < top_) stack_.resize(std::max(top_, stack_.size() + stack_.size() / 2));
    std::array<std::uint32_t*, 8> place;
    for (unsigned octant = 0; octant < 8; ++octant)
        place[octant] =
            (split.counts[octant] <= rule_.leaf_objects ? items_.data() : stack_.data()) + lists[octant].begin;
    for (std::uint32_t i = 0; i < list.count; ++i) {
        const std::uint32_t triangle = stack_[list.begin + i];
        for (unsigned mask = masks_[i]; mask != 0; mask &= mask - 1)
            *place[static_cast<unsigned>(std::countr_zero(mask))]++ = triangle;
    }
    return lists;
}

OctreeNode Builder::make_leaf(List list) {
    const auto first = stack_.begin() + static_cast<std::ptrdiff_t>(list.begin);
    const OctreeNode leaf{static_cast<std::uint32_t>(items_.size()), list.count};
    items_.insert(items_.end(), first, first + list.count);
    return leaf;
}

}  // namespace lumenfarm::octree_detail
