#include "common/math/vec.h"
#include "common/octree/weighted_octree.h"
#include "common/scene/scene_file.h"
#include "master/job.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace lumenfarm {

namespace {

/// With leaves as fine as so many subspaces need, if there can be.
WeightedOctree weigh(const Scene& scene, const std::vector<double>& shares, std::uint32_t subspaces) {
    OctreeOptions options;
    WeightedOctree octree = make_weighted_octree(scene, options, shares);
    for (; Subspaces::most(octree) < subspaces && options.leaf_objects > 1;
         octree = make_weighted_octree(scene, options, shares))
        options.leaf_objects /= 2;
    return octree;
}

/// A ray takes time with the logarithm of what it may meet, which is at first what is in the cell of its light.
std::vector<double> predict_costs(const WeightedOctree& octree, const std::vector<double>& shares) {
    std::map<std::uint32_t, double> cost_by_cell;  // few: a light's cell is the root or one of its octants
    std::vector<double> costs;
    double mean = 0;
    for (std::size_t light = 0; light < shares.size(); ++light) {
        const std::uint32_t cell = octree.light_cells()[light].node;
        const auto [cost, first] = cost_by_cell.try_emplace(cell);
        if (first) cost->second = std::log2(2 + static_cast<double>(filled_leaves(octree.octree(), cell)));
        costs.push_back(cost->second);
        mean += shares[light] * costs.back();
    }
    for (double& cost : costs) cost /= mean;
    return costs;
}

std::string describe(const Scene& scene, const WeightedOctree& weighted) {
    const OctreeSummary octree = summarize(scene, weighted);
    return "its octree has " + std::to_string(octree.nodes) + " nodes for " + std::to_string(octree.triangles) +
           " triangles, depth " + std::to_string(octree.depth) + ", weight " + std::to_string(octree.total_weight);
}

}  // namespace

Result<std::shared_ptr<const PreparedJob>> prepare_job(const JobSpec& spec, std::span<const std::byte> scene_bytes) {
    if (auto good = validate(spec); !good) return good.error();
    auto scene = decode_scene(scene_bytes);
    if (!scene) return scene.error();
    auto prepared = std::make_shared<PreparedJob>();
    prepared->scene = std::move(*scene);
    auto emission = make_emission(prepared->scene);
    if (!emission) return emission.error();
    prepared->emission = std::move(*emission);
    prepared->texel_m = texel_in_force_m(spec, prepared->scene);
    auto layout = TexelLayout::make(prepared->scene, prepared->texel_m);
    if (!layout) return layout.error();
    prepared->layout = std::move(*layout);
    prepared->particles = apportion(prepared->emission, spec.particles);
    std::vector<double> shares;
    for (const LightEmission& light : prepared->emission.lights) shares.push_back(light.share);
    const WeightedOctree octree = weigh(prepared->scene, shares, spec.subspaces);
    prepared->light_costs = predict_costs(octree, shares);
    prepared->octree = describe(prepared->scene, octree);
    if (spec.strategy == Strategy::subspaces) {
        const auto most =
            static_cast<std::uint32_t>(std::min<std::uint64_t>(Subspaces::most(octree), automatic_subspaces));
        auto subspaces = Subspaces::cut(octree, spec.subspaces > 0 ? spec.subspaces : most);
        if (!subspaces) return subspaces.error();
        prepared->subspaces = std::move(*subspaces);
    }
    return std::shared_ptr<const PreparedJob>(std::move(prepared));
}

Packing packing_in_force(const JobSpec& spec, const PreparedJob& prepared) {
    const std::uint64_t map_bytes = prepared.layout.texel_count() * sizeof(wire::TexelDelta) +
                                    prepared.scene.surfaces.size() * sizeof(SurfaceBatches);
    if (spec.packing == Packing::records || map_bytes > limits::map_bytes_max) return Packing::records;
    if (spec.packing == Packing::maps) return Packing::maps;
    return spec.particles >= 2 * prepared.layout.texel_count() ? Packing::maps : Packing::records;
}

}  // namespace lumenfarm
