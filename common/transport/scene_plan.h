#pragma once

#include "common/octree/partition.h"
#include "common/support/digest.h"
#include "common/support/result.h"
#include "common/transport/scene_part.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// What a worker of the object-space strategy knows of the whole scene. The triangles come subspace by subspace, each
/// part a file. The bytes of both: docs/subspaces.md.
namespace lumenfarm {

/// Of a subspace's triangles, or of the compiled scene.
struct PartFile {
    Digest file;
    std::uint64_t bytes = 0;
    std::uint32_t triangles = 0;
    bool operator==(const PartFile&) const = default;
};

struct ScenePlan {
    ScenePart palette;
    SceneExtent extent;                         ///< of the whole scene
    std::vector<std::uint32_t> first_triangle;  ///< of each surface in the whole scene, and behind the last
    Partition partition;
    PartFile whole;                         ///< the compiled scene, for whoever has memory for all of it
    std::vector<PartFile> parts;            ///< by subspace
    std::vector<std::uint16_t> texel_rows;  ///< of each triangle of the whole scene (TexelLayout), or none
    bool operator==(const ScenePlan&) const = default;
};

std::vector<std::byte> encode_plan(const ScenePlan& plan);
/// Reads foreign bytes. Errors: bad_input.
Result<ScenePlan> decode_plan(std::span<const std::byte> bytes);

/// REQUIRES: made by part_of().
std::vector<std::byte> encode_part(const ScenePart& part);
/// Reads foreign bytes. Errors: bad_input.
Result<ScenePart> decode_part(std::span<const std::byte> bytes, const ScenePlan& plan);

}  // namespace lumenfarm
