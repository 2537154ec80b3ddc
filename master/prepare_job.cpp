#include "common/math/vec.h"
#include "common/octree/weighted_octree.h"
#include "common/scene/scene_file.h"
#include "master/job.h"

#include <utility>

namespace lumenfarm {

namespace {

std::string describe_octree(const Scene& scene, const Emission& emission) {
    std::vector<double> shares;
    for (const LightEmission& light : emission.lights) shares.push_back(light.share);
    const OctreeSummary octree = summarize(scene, make_weighted_octree(scene, {}, shares));
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
    const Box box = bounding_box(prepared->scene);
    prepared->texel_m = texel_in_force_m(spec, length(box.high - box.low));
    auto layout = TexelLayout::make(prepared->scene, prepared->texel_m);
    if (!layout) return layout.error();
    prepared->layout = std::move(*layout);
    prepared->particles = apportion(prepared->emission, spec.particles);
    prepared->octree = describe_octree(prepared->scene, prepared->emission);
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
