#include "cli/scene_input.h"

#include "cli/options.h"
#include "common/scene/scene_file.h"
#include "common/scene/text.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <filesystem>
#include <utility>

namespace lumenfarm {
namespace {

constexpr const char* group = "Scene options";

Error about(const SceneOptions& options, Error error) {
    error.sentence = "'" + clean_name(options.file) + "': " + error.sentence;
    return error;
}

bool is_compiled(const SceneOptions& options) { return std::filesystem::path(options.file).extension() == ".lfscene"; }

Result<CompiledScene> read_compiled(const SceneOptions& options) {
    if (options.import.default_light || options.import.ke_scale != 1 || options.import.scale != 1)
        return about(options, bad_input(options.ceiling_light +
                                        ", --ke-scale and --scale act on import; this scene is compiled already"));
    auto bytes = read_file(options.file, limits::scene_bytes_max);
    if (!bytes) return bytes.error();
    auto scene = decode_scene(*bytes);
    if (!scene) return about(options, scene.error());
    return CompiledScene{std::move(*scene), std::move(*bytes)};
}

Result<CompiledScene> import_and_compile(const SceneOptions& options, Console& console) {
    auto imported = import_scene(options.file, options.import);
    if (!imported) return imported.error();
    console.warnings(imported->warnings);
    auto bytes = encode_scene(imported->scene);
    return CompiledScene{std::move(imported->scene), std::move(bytes)};
}

}  // namespace

void declare_scene_options(CLI::App& app, SceneOptions& options) {
    app.add_option("SCENE", options.file, "glTF, GLB, OBJ or another scene file, or a compiled scene (.lfscene)")
        ->type_name("")
        ->required();
    flag_option(app, options.ceiling_light, options.import.default_light,
                "Add a square ceiling light, for scenes that have none")
        ->group(group);
    real_option(app, "--ke-scale", options.import.ke_scale, "OBJ: luminance in cd/m2 that 'Ke 1 1 1' stands for")
        ->group(group);
    real_option(app, "--scale", options.import.scale, "Metres in one unit of the file (glTF is in metres)")
        ->group(group);
}

Result<CompiledScene> read_scene(const SceneOptions& options, Console& console) {
    auto scene = is_compiled(options) ? read_compiled(options) : import_and_compile(options, console);
    if (!scene) return scene;
    if (auto lit = require_light(scene->scene); !lit) return about(options, lit.error());
    return scene;
}

std::string scene_title(const SceneOptions& options) {
    return clean_name(std::filesystem::path(options.file).stem().string());
}

}  // namespace lumenfarm
