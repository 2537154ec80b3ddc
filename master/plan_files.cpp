#include "master/plan_files.h"

#include "common/transport/scene_plan.h"

#include <utility>

namespace lumenfarm {

Result<WorkerFiles> put_plan(FileStore& files, const JobRecord& job, const PreparedJob& prepared,
                             const Partition& cut) {
    const Scene& scene = prepared.scene;
    ScenePlan plan;
    plan.palette = palette_of(scene);
    plan.extent = scene_extent(scene);
    for (const Surface& surface : scene.surfaces) plan.first_triangle.push_back(surface.first_triangle);
    plan.first_triangle.push_back(static_cast<std::uint32_t>(scene.triangles.size()));
    plan.partition = cut;
    plan.whole = {job.status.scene, job.scene_bytes, plan.first_triangle.back()};
    const Subspaces subspaces = Subspaces::of(prepared.subspaces->root(), cut);
    for (const auto& triangles : subspaces.triangles(scene, part_margin_m(plan.extent))) {
        const std::vector<std::byte> bytes = encode_part(part_of(scene, triangles));
        const auto file = files.put(bytes);
        if (!file) return file.error();
        plan.parts.push_back({*file, bytes.size(), static_cast<std::uint32_t>(triangles.size())});
    }
    if (packing_in_force(job.spec, prepared) == Packing::maps) plan.texel_rows = prepared.layout.rows();
    const std::vector<std::byte> bytes = encode_plan(plan);
    const auto file = files.put(bytes);
    if (!file) return file.error();
    return WorkerFiles{*file, bytes.size(), std::move(plan.parts)};
}

}  // namespace lumenfarm
