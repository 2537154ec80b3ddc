#pragma once

#include "common/scene/scene.h"
#include "common/solution/solution.h"
#include "common/solution/texel_layout.h"
#include "common/support/digest.h"
#include "common/support/result.h"
#include "common/transport/emission.h"

#include <cstddef>
#include <filesystem>
#include <span>

/// The folder that `run` and `fetch` leave: DIR/solution.lfs and DIR/scene.lfscene.
namespace lumenfarm {

inline constexpr const char* solution_file_name = "solution.lfs";
inline constexpr const char* scene_file_name = "scene.lfscene";

/// A result with all that is derived from its scene.
struct LoadedRun {
    Scene scene;
    Digest scene_name;
    Emission emission;
    TexelLayout layout;
    Solution solution;
};

/// `path`: the folder, or the solution file inside it. Errors: bad_input (a file is missing, damaged, or of another
/// scene), failed (read error); the sentence names the file.
Result<LoadedRun> load_run(const std::filesystem::path& path);

/// Makes the folder and writes both files, each whole or not at all. REQUIRES: `scene_bytes` is encode_scene of the
/// solution's scene. Errors: failed.
Result<void> save_run(const std::filesystem::path& folder, std::span<const std::byte> scene_bytes,
                      const Solution& solution);

}  // namespace lumenfarm
