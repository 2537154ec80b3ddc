#pragma once

#include "common/scene/scene.h"
#include "common/support/result.h"

#include <filesystem>
#include <string>
#include <vector>

/// Scene files of other programs become compiled scenes. docs/scenes.md says what is read and how it is mapped.
namespace lumenfarm {

struct ImportOptions {
    bool default_light = false;  ///< adds a square light that shines down from under the top of the scene
    double ke_scale = 1;         ///< OBJ: luminance [cd/m2] of `Ke 1 1 1`
    double scale = 1;            ///< metres per unit of files without a unit (not glTF, which is in metres)
};

struct ImportedScene {
    Scene scene;                        ///< validate(scene) succeeds; it may have no light (require_light)
    std::vector<std::string> warnings;  ///< what was skipped or approximated, a sentence each, named
};

/// Reads glTF 2.0 (.gltf, .glb), OBJ with MTL (.obj) and what Assimp reads, by the file's extension.
/// Errors: bad_input with one sentence that names file, element and value.
Result<ImportedScene> import_scene(const std::filesystem::path& path, const ImportOptions& options);

/// Errors: bad_input when nothing in the scene emits light; the sentence names the option --light.
Result<void> require_light(const Scene& scene);

}  // namespace lumenfarm
