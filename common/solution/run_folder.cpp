#include "common/solution/run_folder.h"

#include "common/scene/scene_file.h"
#include "common/solution/solution_file.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <utility>

namespace lumenfarm {
namespace {

Error about(const std::filesystem::path& file, Error error) {
    error.sentence = "'" + file.string() + "': " + error.sentence;
    return error;
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
    std::error_code error;
    if (path.filename() != solution_file_name || std::filesystem::is_directory(path, error)) return path;
    return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

}  // namespace

Result<LoadedRun> load_run(const std::filesystem::path& path) {
    const std::filesystem::path folder = folder_of(path);
    const std::filesystem::path scene_path = folder / scene_file_name;
    const std::filesystem::path solution_path = folder / solution_file_name;

    auto solution_bytes = read_file(solution_path, limits::solution_bytes_max);
    if (!solution_bytes) return solution_bytes.error();
    const auto scene_bytes = read_file(scene_path, limits::scene_bytes_max);
    if (!scene_bytes) return scene_bytes.error();
    auto scene = decode_scene(*scene_bytes);
    if (!scene) return about(scene_path, scene.error());
    const Digest scene_name = scene_digest(*scene_bytes);

    auto solution = decode_solution(*solution_bytes, *scene, scene_name);
    if (!solution) return about(solution_path, solution.error());
    auto emission = make_emission(*scene);
    if (!emission) return about(scene_path, emission.error());
    auto layout = TexelLayout::make(*scene, solution->spec);
    if (!layout) return about(scene_path, layout.error());
    return LoadedRun{std::move(*scene), scene_name, std::move(*emission), std::move(*layout), std::move(*solution)};
}

Result<void> save_run(const std::filesystem::path& folder, std::span<const std::byte> scene_bytes,
                      const Solution& solution) {
    if (const auto made = make_folder(folder); !made) return made.error();
    if (const auto written = write_file(folder / scene_file_name, scene_bytes); !written) return written.error();
    return write_file(folder / solution_file_name, encode_solution(solution).bytes);
}

}  // namespace lumenfarm
