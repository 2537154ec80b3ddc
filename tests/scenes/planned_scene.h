#pragma once

#include "common/octree/subspaces.h"
#include "common/scene/scene_file.h"
#include "common/transport/scene_plan.h"
#include "tests/scenes/scene_builder.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lumenfarm::testing {

/// mixed_room() in subspaces, as a master plans it.
struct PlannedScene {
    explicit PlannedScene(std::uint32_t count)
        : subspaces(Subspaces::cut(make_weighted_octree(scene, {}, std::vector<double>(scene.lights.size(), 1)), count)
                        .value()) {
        plan.palette = palette_of(scene);
        plan.extent = scene_extent(scene);
        plan.partition = subspaces.partition();
        for (const Surface& surface : scene.surfaces) plan.first_triangle.push_back(surface.first_triangle);
        plan.first_triangle.push_back(static_cast<std::uint32_t>(scene.triangles.size()));
        const auto scene_bytes = encode_scene(scene);
        plan.whole = {scene_digest(scene_bytes), scene_bytes.size(), plan.first_triangle.back()};
        plan.texel_rows.assign(scene.triangles.size(), 3);
        const auto triangles = subspaces.triangles(scene, part_margin_m(plan.extent));
        for (const auto& of_subspace : triangles) {
            parts.push_back(part_of(scene, of_subspace));
            part_bytes.push_back(encode_part(parts.back()));
            plan.parts.push_back(
                {sha256(part_bytes.back()), part_bytes.back().size(), static_cast<std::uint32_t>(of_subspace.size())});
        }
    }

    Scene scene = mixed_room();
    Subspaces subspaces;
    ScenePlan plan;
    std::vector<ScenePart> parts;  ///< by subspace
    std::vector<std::vector<std::byte>> part_bytes;
};

}  // namespace lumenfarm::testing
