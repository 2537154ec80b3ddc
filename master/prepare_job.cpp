#include "common/math/vec.h"
#include "common/octree/weighted_octree.h"
#include "common/scene/scene_file.h"
#include "master/job.h"

#include <algorithm>
#include <utility>

namespace lumenfarm {

namespace {

/// With leaves as fine as so many subspaces need, if there can be.
WeightedOctree weigh(const Scene& scene, const Emission& emission, std::uint32_t subspaces) {
    std::vector<double> shares;
    for (const LightEmission& light : emission.lights) shares.push_back(light.share);
    OctreeOptions options;
    WeightedOctree octree = make_weighted_octree(scene, options, shares);
    for (; Subspaces::most(octree) < subspaces && options.leaf_objects > 1;
         octree = make_weighted_octree(scene, options, shares))
        options.leaf_objects /= 2;
    return octree;
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
    const WeightedOctree octree = weigh(prepared->scene, prepared->emission, spec.subspaces);
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
