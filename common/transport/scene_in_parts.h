#pragma once

#include "common/octree/subspaces.h"
#include "common/support/result.h"
#include "common/transport/scene_part.h"
#include "common/transport/territory.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace lumenfarm {

/// A scene in parts, each at hand at one of some places, where no farm is needed to trace it.
struct SceneInParts {
    /// Errors: as PartTracer::make. REQUIRES: places > 0.
    static Result<std::unique_ptr<SceneInParts>> make(const Scene& scene, Subspaces cut, std::uint32_t places = 1);

    Subspaces subspaces;
    ScenePart palette;
    SceneExtent extent;
    std::vector<Territory> territories;  ///< by place, of the partition of `subspaces`
    std::size_t triangles = 0;           ///< of all parts
};

}  // namespace lumenfarm
