#include "common/imaging/render.h"

#include <cmath>

namespace lumenfarm {

View::View(const Camera& camera, std::uint32_t width, std::uint32_t height) : origin_(camera.position) {
    constexpr double degree = 3.14159265358979323846 / 180;
    const Vec3d forward = normalize(camera.forward);
    const Vec3d right = normalize(cross(forward, camera.up));
    const Vec3d up = cross(right, forward);
    const double pixel = 2 * std::tan(camera.vertical_fov_degrees * degree / 2) / height;
    right_ = right * pixel;
    down_ = -up * pixel;
    corner_ = forward - right_ * (0.5 * width) - down_ * (0.5 * height);
}

Vec3d View::direction(double x, double y) const { return normalize(corner_ + right_ * x + down_ * y); }

}  // namespace lumenfarm
