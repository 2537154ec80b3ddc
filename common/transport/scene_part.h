#pragma once

#include "common/scene/scene.h"
#include "common/transport/ray_query.h"

#include <cstdint>
#include <span>
#include <vector>

/// Pieces of a scene that is larger than the memory of those that trace it (docs/subspaces.md).
namespace lumenfarm {

/// Some triangles of a scene, in its order.
struct ScenePart {
    Scene scene;
    std::vector<std::uint32_t> numbers;  ///< of its triangles in the whole scene, ascending
    bool operator==(const ScenePart&) const = default;
};

/// These triangles, and the surfaces that have some of them, without names; nothing else of the scene. There may be
/// none. REQUIRES: ascending, of the scene.
ScenePart part_of(const Scene& scene, std::span<const std::uint32_t> triangles);

/// The scene without cameras and without most triangles: those of a surface that emits light are there, and the first
/// of every other, so that it is a valid scene.
ScenePart palette_of(const Scene& scene);

/// How near to a subspace a triangle may pass that has to be in its part [m].
double part_margin_m(const SceneExtent& extent);

}  // namespace lumenfarm
