#pragma once

#include "cli/products/camera_choice.h"
#include "common/imaging/render.h"
#include "common/solution/run_folder.h"
#include "common/support/result.h"
#include "common/transport/tracer.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// `render`, and the pictures and the report that `run` leaves in its folder.
namespace lumenfarm {

struct PictureOptions {
    std::optional<PictureSize> size;  ///< none: 800 pixels along the longer side of the camera's shape
    std::uint32_t samples_per_side = 3;
    std::uint32_t threads = 0;  ///< 0: one a core
    Estimator estimator = Estimator::automatic;
};

/// Renders a camera. `path` ends in .exr: that file and the tone-mapped .png beside it; in .png: only that.
/// Errors: bad_input (view, size, ending), failed (output).
Result<void> render_to(const LoadedRun& run, const TracerScene& tracer, const Camera& camera,
                       const PictureOptions& options, const std::filesystem::path& path);

/// A PNG and an EXR for each camera of the scene (framing_camera when there is none), and report.json.
/// Gives the names of the pictures. Errors: failed.
Result<std::vector<std::string>> write_products(const LoadedRun& run, const TracerScene& tracer,
                                                const std::filesystem::path& folder, const PictureOptions& options);

}  // namespace lumenfarm
