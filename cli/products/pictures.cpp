#include "cli/products/pictures.h"

#include "cli/products/inspect.h"
#include "cli/products/json_text.h"
#include "common/imaging/picture_file.h"
#include "common/imaging/tone_map.h"
#include "common/support/file.h"

#include <algorithm>

namespace lumenfarm {
namespace {

constexpr std::size_t file_name_bytes_max = 100;

/// A file name from a camera's: letters and digits stay, so that no name becomes a path.
std::string file_name(const std::string& camera, const std::vector<std::string>& taken) {
    std::string name;
    for (const char c : camera.substr(0, file_name_bytes_max)) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
        name += plain ? c : '_';
    }
    if (name.empty()) name = "view";
    std::string unique = name;
    for (int i = 2; std::find(taken.begin(), taken.end(), unique) != taken.end(); ++i)
        unique = name + "-" + std::to_string(i);
    return unique;
}

}  // namespace

Result<void> render_to(const LoadedRun& run, const TracerScene& tracer, const Camera& camera,
                       const PictureOptions& options, const std::filesystem::path& path) {
    const bool layers = path.extension() == ".exr";
    if (!layers && path.extension() != ".png")
        return bad_input("'" + path.string() + "' ends neither in .exr nor in .png");
    const PictureSize size = options.size.value_or(default_picture_size(camera.aspect));
    const auto picture = render(
        run, tracer, camera, {size.width, size.height, options.samples_per_side, options.threads, options.estimator});
    if (!picture) return picture.error();
    if (layers)
        if (const auto written = write_exr(path, *picture); !written) return written.error();
    const Appearance appearance(run.scene, run.emission);
    const auto rgb = tone_map(*picture, automatic_tone(*picture, appearance.light_white()));
    std::filesystem::path png = path;
    return write_png(png.replace_extension(".png"), size.width, size.height, rgb);
}

Result<std::vector<std::string>> write_products(const LoadedRun& run, const TracerScene& tracer,
                                                const std::filesystem::path& folder, const PictureOptions& options) {
    std::vector<Camera> cameras = run.scene.cameras;
    if (cameras.empty()) cameras.push_back(framing_camera(run.scene, tracer));
    std::vector<std::string> names, pictures;
    for (const Camera& camera : cameras) {
        names.push_back(file_name(camera.name, names));
        const auto made = render_to(run, tracer, camera, options, folder / (names.back() + ".exr"));
        if (!made) return made.error();
        pictures.push_back(names.back() + ".png");
        pictures.push_back(names.back() + ".exr");
    }
    const auto written = write_file(folder / "report.json", json_text(report_document(run, pictures)));
    if (!written) return written.error();
    return pictures;
}

}  // namespace lumenfarm
