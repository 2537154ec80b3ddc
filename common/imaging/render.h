#pragma once

#include "common/imaging/incident_light.h"
#include "common/imaging/picture.h"
#include "common/scene/scene.h"
#include "common/solution/run_folder.h"
#include "common/support/result.h"
#include "common/transport/tracer.h"

#include <cstdint>

/// Views of a solution: camera rays follow mirrors and glass to the first diffuse surface and show its light.
namespace lumenfarm {

struct RenderOptions {
    std::uint32_t width = 800;
    std::uint32_t height = 600;
    std::uint32_t samples_per_side = 3;  ///< 3: nine rays a pixel
    std::uint32_t threads = 0;           ///< 0: one a core; the picture does not depend on it
    Estimator estimator = Estimator::automatic;
};

/// REQUIRES: `tracer` was made for run.scene. Errors: bad_input (size or samples out of limits, a camera that is not a
/// camera).
Result<Picture> render(const LoadedRun& run, const TracerScene& tracer, const Camera& camera,
                       const RenderOptions& options);

/// A camera as its image plane: the direction of each point of the picture.
class View {
public:
    View(const Camera& camera, std::uint32_t width, std::uint32_t height);
    Vec3d origin() const { return origin_; }
    /// Unit direction through (x, y) in pixels from the top left.
    Vec3d direction(double x, double y) const;

private:
    Vec3d origin_, corner_, right_, down_;
};

}  // namespace lumenfarm
