#pragma once

#include "common/scene/scene.h"
#include "common/support/result.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <optional>
#include <string>

/// Which view a user asks for.
namespace lumenfarm {

struct ViewRequest {
    std::optional<std::string> camera;  ///< by name; not together with look_from or look_at
    std::optional<Vec3d> look_from;     ///< [m]
    std::optional<Vec3d> look_at;       ///< [m]
    std::optional<double> fov_degrees;  ///< vertical; 45 where nothing else is said
};

/// The camera of a request; for an empty one the scene's first camera, or framing_camera.
/// Errors: bad_input (no such camera: the sentence lists those there are; half a request; a direction of no length).
Result<Camera> choose_camera(const Scene& scene, const TracerScene& tracer, const ViewRequest& request);

/// A view of the whole scene: from outside through a side that is open, or from a corner of a closed room.
Camera framing_camera(const Scene& scene, const TracerScene& tracer);

struct PictureSize {
    std::uint32_t width = 0, height = 0;
};
/// "WxH" in pixels. Errors: bad_input.
Result<PictureSize> parse_picture_size(const std::string& text);
/// 800 pixels along the longer side.
PictureSize default_picture_size(double aspect);

}  // namespace lumenfarm
