#pragma once

#include "common/octree/octree.h"
#include "common/octree/triangle_box.h"

#include <array>
#include <cstdint>
#include <vector>

/// The recursion that grows an octree, or a part of one, from a list of triangles. Private to common/octree.
namespace lumenfarm::octree_detail {

/// What may still be made below a cell.
struct Budget {
    std::uint64_t nodes = 0;
    std::uint64_t references = 0;  ///< more than the cell has: a split repeats triangles that several children overlap
};

/// A cell that waits to be grown with the triangles that overlap it.
struct Seed {
    std::uint32_t node = 0;
    Cube cube{};
    std::uint32_t depth = 0;
    Budget budget;
    std::vector<std::uint32_t> triangles;
};

/// When to split (Octree::make).
struct SplitRule {
    std::uint32_t leaf_objects = 0;
    std::uint32_t depth_max = 0;   ///< no cell is deeper
    std::uint32_t seed_count = 0;  ///< cells that would split and have at most so many triangles become seeds instead
};

/// What grew from one seed: its own node, and where the rest stands in the builder's arrays.
struct Part {
    OctreeNode root;
    std::size_t node_begin = 0, node_end = 0;
    std::size_t item_begin = 0, item_end = 0;
};

/// Appends nodes and items to its arrays: parents before children, octants side by side.
class Builder {
public:
    /// corners: nine floats for each triangle, and one more at the end. It outlives this.
    Builder(const float* corners, SplitRule rule) : corners_(corners), rule_(rule) {}

    /// Grows the seed. The part's root is returned, not stored.
    Part grow(Seed seed);

    void set_seed_count(std::uint32_t count) { rule_.seed_count = count; }
    std::vector<OctreeNode>& nodes() { return nodes_; }
    std::vector<std::uint32_t>& items() { return items_; }
    /// Cells that are to be grown; their nodes are empty leaves so far.
    std::vector<Seed>& seeds() { return seeds_; }

private:
    /// Triangles in stack_[begin, begin + count).
    struct List {
        std::size_t begin = 0;
        std::uint32_t count = 0;
    };
    struct Split {
        std::array<std::uint32_t, 8> counts{};
        std::uint64_t references = 0;  ///< the sum of the counts
        std::uint64_t crowd = 0;       ///< the sum over the children that may split in turn
    };

    OctreeNode grow_cell(std::uint32_t node, const Cube& cube, std::uint32_t depth, List list, Budget budget);
    void keep_seed(std::uint32_t node, const Cube& cube, std::uint32_t depth, List list, Budget budget);
    bool wants_split(const Cube& cube, std::uint32_t depth, List list, Budget budget) const;
    bool meet_in_a_corner(const Cube& cube, List list) const;
    Split classify(const Cube& cube, List list);
    bool is_worthwhile(const Split& split, List list, Budget budget) const;
    std::array<List, 8> scatter(const Split& split, List list, OctreeNode* children);
    Budget share(Budget budget, const Split& split, List parent, List child) const;
    OctreeNode make_leaf(List list);

    const float* corner(std::uint32_t triangle, std::size_t k) const {
        return corners_ + 9 * std::size_t{triangle} + 3 * k;
    }

    const float* corners_;
    SplitRule rule_;
    std::vector<OctreeNode> nodes_;
    std::vector<std::uint32_t> items_;
    std::vector<Seed> seeds_;
    std::vector<std::uint32_t> stack_;  ///< the lists of the cells on the way from the root
    std::size_t top_ = 0;               ///< the end of the lists in use
    std::vector<std::uint8_t> masks_;   ///< the octants of each triangle of the cell in work
};

}  // namespace lumenfarm::octree_detail
