#pragma once

#include "cli/console.h"
#include "cli/import/import.h"
#include "common/scene/scene.h"
#include "common/support/result.h"

#include <CLI/CLI.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace lumenfarm {

/// SCENE and the options of its import.
struct SceneOptions {
    std::string file;
    ImportOptions import;
    std::string ceiling_light = "--light";  ///< the name of the flag that adds one
};
void declare_scene_options(CLI::App& app, SceneOptions& options);

struct CompiledScene {
    Scene scene;                   ///< it has a light
    std::vector<std::byte> bytes;  ///< encode_scene
};

/// Imports a scene file, or reads a compiled one (.lfscene). The import's warnings go to the console.
/// Errors: bad_input with a sentence that names the file.
Result<CompiledScene> read_scene(const SceneOptions& options, Console& console);

/// "cornell" of "scenes/cornell.gltf".
std::string scene_title(const SceneOptions& options);

}  // namespace lumenfarm
