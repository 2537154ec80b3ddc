#pragma once

#include "common/scene/scene.h"
#include "common/support/limits.h"

#include <cstdint>
#include <span>
#include <vector>

/// The adaptive octree over a scene's triangles (docs/octree.md).
namespace lumenfarm {

/// When cells split. The tree is a pure function of the scene and the first three; `threads` never changes it.
struct OctreeOptions {
    std::uint32_t leaf_objects = 4;  ///< a cell that more triangles overlap is split
    std::uint32_t depth_max = limits::octree_depth_max;
    std::uint64_t nodes_max = 0;  ///< 0: some for each triangle (octree.cpp); at most limits::octree_nodes_max
    std::uint32_t threads = 1;    ///< that build it; at most limits::octree_threads_max
};

/// 8 bytes. Children stand side by side: octant o (bit 0 upper half in x, bit 1 in y, bit 2 in z) is first + o.
struct OctreeNode {
    static constexpr std::uint32_t inner = none;

    std::uint32_t first = 0;  ///< inner: the first child's index; leaf: its first triangle in Octree::items()
    std::uint32_t count = 0;  ///< leaf: its triangles; `inner` otherwise

    bool is_leaf() const { return count != inner; }
    bool is_empty_leaf() const { return count == 0; }
    bool operator==(const OctreeNode&) const = default;
};
static_assert(sizeof(OctreeNode) == 8);
static_assert(limits::octree_nodes_max < OctreeNode::inner);
static_assert(limits::octree_references_max < OctreeNode::inner);
static_assert(limits::triangles_max <= limits::octree_references_max);

/// A node and where it is: the cell of a 2^depth grid over the root.
struct OctreeCell {
    std::uint32_t node = 0;
    std::uint32_t depth = 0;
    std::uint32_t x = 0, y = 0, z = 0;
    bool operator==(const OctreeCell&) const = default;
};

/// Cubes within a cubic root. All bounds of cells are exact: neighbours share the very same numbers.
class Octree {
public:
    /// A cell splits when more than leaf_objects triangles overlap it (closed cube, closed triangle), unless
    /// - it is at the depth limit, or its share of the limits on nodes and references is used up (references:
    ///   at most 32 a triangle and 4,096 more);
    /// - all its triangles meet in a corner that lies in the cell: no split parts them;
    /// - it has at most 4 leaf_objects of them and at least two children would hold them all, the others none.
    /// Every triangle is in each leaf that it overlaps and in none that its bounding box does not touch.
    /// REQUIRES: validate(scene) succeeds; leaf_objects > 0; depth_max <= limits::octree_depth_max;
    /// nodes_max <= limits::octree_nodes_max.
    static Octree make(const Scene& scene, const OctreeOptions& options = {});

    std::span<const OctreeNode> nodes() const { return nodes_; }  ///< the root is first; parents before children
    std::span<const std::uint32_t> items() const { return items_; }
    /// Triangles of a leaf in ascending order. REQUIRES: node.is_leaf().
    std::span<const std::uint32_t> triangles(const OctreeNode& node) const {
        return items().subspan(node.first, node.count);
    }

    static OctreeCell root() { return {}; }
    /// REQUIRES: an inner cell; octant < 8.
    OctreeCell child(const OctreeCell& cell, std::uint32_t octant) const {
        return {nodes_[cell.node].first + octant, cell.depth + 1, 2 * cell.x + (octant & 1),
                2 * cell.y + (octant >> 1 & 1), 2 * cell.z + (octant >> 2)};
    }
    Box box(const OctreeCell& cell) const;  ///< [m]; exact

    /// The leaf that holds the point: of two leaves that touch there, the upper one. none outside the root.
    std::uint32_t leaf_of(Vec3d point) const;

    /// visit(cell) for every node, parents before children, octants in order.
    template <class Visit>
    void for_each_cell(Visit&& visit) const {
        visit_below(root(), visit);
    }

private:
    template <class Visit>
    void visit_below(const OctreeCell& cell, Visit& visit) const {
        visit(cell);
        if (nodes_[cell.node].is_leaf()) return;
        for (std::uint32_t octant = 0; octant < 8; ++octant) visit_below(child(cell, octant), visit);
    }

    std::vector<OctreeNode> nodes_{OctreeNode{}};
    std::vector<std::uint32_t> items_;
    Vec3d low_m_;        ///< corner of the root
    double side_m_ = 0;  ///< of the root
};

}  // namespace lumenfarm
