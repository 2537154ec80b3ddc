#pragma once

#include "common/octree/subspaces.h"
#include "common/transport/emission.h"
#include "common/transport/emitter.h"
#include "common/transport/scene_part.h"
#include "common/transport/territory.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace lumenfarm::testing {

inline WeightedOctree weigh(const Scene& scene) {
    std::vector<double> shares;
    for (const LightEmission& light : make_emission(scene).value().lights) shares.push_back(light.share);
    return make_weighted_octree(scene, {}, shares);
}

/// A scene in parts, of which each is at hand at one of `places`.
struct SceneInParts {
    SceneInParts(const Scene& scene, Subspaces cut, std::uint32_t places = 1)
        : subspaces(std::move(cut)), palette(palette_of(scene)), extent(scene_extent(scene)) {
        const std::uint32_t all = subspaces.partition().subspaces();
        std::vector<std::vector<std::shared_ptr<const PartTracer>>> held(
            places, std::vector<std::shared_ptr<const PartTracer>>(all));
        std::uint32_t made = 0;
        for (const auto& filed : subspaces.triangles(scene, part_margin_m(extent))) {
            ScenePart part = part_of(scene, filed);
            triangles += part.numbers.size();
            held[made % places][made] = PartTracer::make(std::move(part), palette.scene, extent).value();
            ++made;
        }
        for (auto& place : held) territories.emplace_back(subspaces.partition(), std::move(place));
    }
    SceneInParts(const SceneInParts&) = delete;

    Subspaces subspaces;
    ScenePart palette;
    SceneExtent extent;
    std::vector<Territory> territories;
    std::size_t triangles = 0;
};

}  // namespace lumenfarm::testing
