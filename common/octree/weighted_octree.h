#pragma once

#include "common/octree/octree.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// The weighted octree: what work to expect in each part of space (docs/octree.md).
namespace lumenfarm {

/// All lights of a scene together weigh so many times its non-empty leaves, unless the caller says otherwise.
inline constexpr double default_light_weight = 1.0;

/// Where a light is, and what it adds to the weight of its cell.
struct LightPlace {
    Box extent;         ///< [m]; a point for point and spot lights
    double weight = 0;  ///< >= 0
};

/// An octree with a weight for each node: a non-empty leaf 1, an empty leaf 0, and each light's weight at its cell,
/// shared equally among that cell's non-empty children, down to the leaves. An inner node is the sum of its children.
class WeightedOctree {
public:
    WeightedOctree(Octree octree, std::span<const LightPlace> lights);

    const Octree& octree() const { return octree_; }
    double weight(std::uint32_t node) const { return weights_[node]; }
    double total_weight() const { return weights_[0]; }
    /// For each light the cell that its weight went to.
    std::span<const OctreeCell> light_cells() const { return light_cells_; }
    double added_weight(std::size_t light) const { return added_weights_[light]; }

private:
    void weigh_leaves();
    void hand_down(std::vector<double>& added);
    void sum_up();

    Octree octree_;
    std::vector<double> weights_;
    std::vector<OctreeCell> light_cells_;
    std::vector<double> added_weights_;
};

/// Light l weighs light_shares[l] * light_weight * (number of non-empty leaves).
/// REQUIRES: a share >= 0 for each light of the scene (LightEmission::share), and what Octree::make requires.
WeightedOctree make_weighted_octree(const Scene& scene, const OctreeOptions& options,
                                    std::span<const double> light_shares, double light_weight = default_light_weight);

/// The position of a point or spot light, the bounding box of a surface light.
Box light_extent(const Scene& scene, const Light& light);

/// The cell that a light's weight goes to: the largest below the root that holds the extent wholly and is not empty;
/// the root when there is none, as for a light that crosses the root's middle planes or lies outside.
OctreeCell light_cell(const Octree& octree, const Box& extent);

/// Leaves below a node that hold triangles: its weight without lights.
std::uint64_t filled_leaves(const Octree& octree, std::uint32_t node);

/// What `inspect --octree` shows.
struct OctreeSummary {
    struct LightCell {
        std::string light;
        Box box;                  ///< of the cell [m]
        std::uint32_t depth = 0;  ///< of the cell
        double added_weight = 0;  ///< by this light
        double cell_weight = 0;   ///< of the cell, all in all
    };

    std::uint64_t triangles = 0;
    std::uint64_t nodes = 0;
    std::uint64_t leaves = 0;  ///< empty ones too
    std::uint64_t empty_leaves = 0;
    std::uint64_t references = 0;    ///< triangles in leaves, each as often as it stands in one
    std::uint32_t fullest_leaf = 0;  ///< triangles in it
    std::uint32_t depth = 0;         ///< of the deepest leaf; the root alone has 0
    double total_weight = 0;
    double light_weight = 0;  ///< the lights' part of it
    Box root;
    std::vector<LightCell> lights;
};

/// REQUIRES: `octree` was made from this scene with these lights.
OctreeSummary summarize(const Scene& scene, const WeightedOctree& octree);

}  // namespace lumenfarm
