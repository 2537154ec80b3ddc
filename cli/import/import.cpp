#include "cli/import/import.h"

#include "cli/import/readers.h"
#include "common/scene/text.h"

#include <algorithm>
#include <cctype>
#include <exception>

namespace lumenfarm {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

Result<void> check_options(const ImportOptions& options) {
    const auto sane = [](double factor) { return factor >= 1e-9 && factor <= 1e9; };
    if (!sane(options.scale))
        return bad_input("the scale is " + std::to_string(options.scale) + "; it must lie from 1e-9 to 1e9 metres");
    if (!sane(options.ke_scale))
        return bad_input("the Ke scale is " + std::to_string(options.ke_scale) +
                         "; it must lie from 1e-9 to 1e9 cd/m2");
    return {};
}

Result<void> read_any(import::SceneBuilder& builder, const ImportOptions& options) {
    const std::string extension = lower_extension(builder.file());
    if (extension == ".gltf" || extension == ".glb") return import::read_gltf(builder);
    if (extension == ".obj") return import::read_obj(builder, options);
    if (import::assimp_reads(extension)) return import::read_by_assimp(builder, options);
    return builder.refuse("the file's extension '" + extension + "' is none that is read (.gltf, .glb, .obj, .ply, " +
                          ".stl, .dae, .fbx, .3ds and others)");
}

}  // namespace

Result<ImportedScene> import_scene(const std::filesystem::path& path, const ImportOptions& options) {
    if (auto checked = check_options(options); !checked) return checked.error();
    import::SceneBuilder builder(path);
    std::error_code why;
    const auto status = std::filesystem::status(path, why);
    if (!std::filesystem::exists(status)) return builder.refuse("the file does not exist");
    if (!std::filesystem::is_regular_file(status)) return builder.refuse("this is not a regular file");
    try {
        if (auto read = read_any(builder, options); !read) return read.error();
        return builder.finish(options);
    } catch (const std::bad_alloc&) {
        return failed("'" + clean_name(path.string()) + "': there is not enough memory to read the file");
    }
}

Result<void> require_light(const Scene& scene) {
    if (!scene.lights.empty()) return {};
    return bad_input("nothing in the scene emits light; --light adds a light under its top");
}

}  // namespace lumenfarm
