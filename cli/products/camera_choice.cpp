#include "cli/products/camera_choice.h"

#include "common/support/limits.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

namespace lumenfarm {
namespace {

constexpr double longer_side_pixels = 800;
constexpr double outside_fov_degrees = 40;
constexpr double inside_fov_degrees = 75;
constexpr double into_corner = 0.92;  // of the way from the middle to the wall behind the camera

/// A vertical view needs another up than y.
Vec3d up_for(Vec3d forward) { return std::abs(forward.y) > 0.999 * length(forward) ? Vec3d{0, 0, -1} : Vec3d{0, 1, 0}; }

Camera looking(std::string name, Vec3d from, Vec3d at, double fov_degrees) {
    const Vec3d forward = normalize(at - from);
    return {std::move(name), from, forward, up_for(forward), fov_degrees, 4.0 / 3};
}

bool open(const TracerScene& tracer, Vec3d from, Vec3d direction) {
    return tracer.meet(from, normalize(direction)).triangle == none;
}

Result<Camera> named_camera(const Scene& scene, const std::string& name) {
    std::string known;
    for (const Camera& camera : scene.cameras) {
        if (camera.name == name) return camera;
        if (known.size() < 400) known += (known.empty() ? "" : ", ") + ("'" + camera.name + "'");
    }
    return bad_input("the scene has no camera '" + name + "'" +
                     (known.empty() ? "; it has none at all" : "; it has " + known));
}

}  // namespace

Camera framing_camera(const Scene& scene, const TracerScene& tracer) {
    const Box box = bounding_box(scene);
    const Vec3d middle = (box.low + box.high) * 0.5;
    const double radius = std::max(length(box.high - box.low) / 2, 1e-6);
    // through the first of these that nothing bars, seen from the middle
    const std::array<Vec3d, 7> ways{Vec3d{0.5, 0.4, 1}, Vec3d{0, 0, 1},    Vec3d{0, 0, -1},   Vec3d{1, 0, 0},
                                    Vec3d{-1, 0, 0},    Vec3d{0, 1, 0.01}, Vec3d{0, -1, 0.01}};
    std::vector<Vec3d> ways_out;
    for (const Vec3d way : ways)
        if (open(tracer, middle, way)) ways_out.push_back(normalize(way));
    if (!ways_out.empty()) {
        constexpr double half = outside_fov_degrees / 2 * 3.14159265358979323846 / 180;
        return looking("view", middle + ways_out[0] * (radius / std::sin(half)), middle, outside_fov_degrees);
    }
    const Vec3d half_size = (box.high - box.low) * 0.5;
    const Vec3d corner{half_size.x, 0.3 * half_size.y, half_size.z};
    const auto wall = tracer.meet(middle, corner);
    const double reach = wall.triangle == none ? 1 : std::min(wall.distance, 1.0);
    return looking("view", middle + corner * (into_corner * reach), middle - corner * 0.3, inside_fov_degrees);
}

Result<Camera> choose_camera(const Scene& scene, const TracerScene& tracer, const ViewRequest& request) {
    const bool looks = request.look_from || request.look_at;
    if (request.camera && looks) return bad_input("a view is either a named camera or a place to look from, not both");
    if (request.fov_degrees && !(*request.fov_degrees > 0 && *request.fov_degrees < 180))
        return bad_input("the field of view is " + std::to_string(*request.fov_degrees) +
                         " degrees; it must lie between 0 and 180");
    if (looks) {
        if (!request.look_from || !request.look_at)
            return bad_input("a view needs both a place to look from and one to look at");
        const double distance = length(*request.look_at - *request.look_from);
        if (!(distance > 0) || !std::isfinite(distance))
            return bad_input("the place to look at is the place to look from, or is not finite");
        return looking("view", *request.look_from, *request.look_at, request.fov_degrees.value_or(45));
    }
    Result<Camera> camera = request.camera          ? named_camera(scene, *request.camera)
                            : scene.cameras.empty() ? Result<Camera>(framing_camera(scene, tracer))
                                                    : Result<Camera>(scene.cameras[0]);
    if (camera && request.fov_degrees) camera->vertical_fov_degrees = *request.fov_degrees;
    return camera;
}

Result<PictureSize> parse_picture_size(const std::string& text) {
    PictureSize size;
    const char* end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, size.width);
    const bool parted = width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x';
    const auto height = parted ? std::from_chars(width.ptr + 1, end, size.height) : width;
    const auto fits = [](std::uint32_t side) { return side > 0 && side <= limits::picture_side_max; };
    if (!parted || height.ec != std::errc{} || height.ptr != end || !fits(size.width) || !fits(size.height))
        return bad_input("'" + text + "' is not a picture size WxH with sides from 1 to " +
                         std::to_string(limits::picture_side_max));
    return size;
}

PictureSize default_picture_size(double aspect) {
    const double shape = std::isfinite(aspect) && aspect > 0 ? std::clamp(aspect, 0.05, 20.0) : 1;
    const auto pixels = [](double side) { return static_cast<std::uint32_t>(std::lround(side)); };
    if (shape >= 1) return {pixels(longer_side_pixels), pixels(longer_side_pixels / shape)};
    return {pixels(longer_side_pixels * shape), pixels(longer_side_pixels)};
}

}  // namespace lumenfarm
