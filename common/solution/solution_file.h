#pragma once

#include "common/scene/scene.h"
#include "common/solution/solution.h"
#include "common/support/digest.h"
#include "common/support/result.h"

#include <cstddef>
#include <span>
#include <vector>

/// The bytes of solution.lfs (docs/solution_file.md). Little-endian; readable only beside its scene.
namespace lumenfarm {

struct EncodedSolution {
    std::vector<std::byte> bytes;
    Digest digest;  ///< solution_digest()
};
EncodedSolution encode_solution(const Solution& solution);

/// Reads foreign bytes: everything that solution.h says of the fields is checked against the scene, and memory taken is
/// bounded by what the scene and the job allow. REQUIRES: validate(scene) succeeds; `scene_name` is its digest.
/// Errors: bad_input (damaged, cut short, of another scene or version) with one sentence that does not name the file.
Result<Solution> decode_solution(std::span<const std::byte> bytes, const Scene& scene, const Digest& scene_name);

}  // namespace lumenfarm
