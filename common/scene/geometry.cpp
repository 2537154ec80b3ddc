#include "common/scene/scene.h"

#include <algorithm>

namespace lumenfarm {
namespace {

Vec3d corner(const Scene& scene, std::uint32_t triangle, std::size_t which) {
    return scene.positions[scene.triangles[triangle][which]].as<double>();
}

}  // namespace

Vec3d triangle_cross(const Scene& scene, std::uint32_t triangle) {
    const Vec3d a = corner(scene, triangle, 0);
    return cross(corner(scene, triangle, 1) - a, corner(scene, triangle, 2) - a);
}

double triangle_area_m2(const Scene& scene, std::uint32_t triangle) {
    return 0.5 * length(triangle_cross(scene, triangle));
}

Box bounding_box(const Scene& scene) {
    Box box;
    for (const Triangle& triangle : scene.triangles) {
        for (const std::uint32_t vertex : triangle) {
            const Vec3d p = scene.positions[vertex].as<double>();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box.low[axis] = std::min(box.low[axis], p[axis]);
                box.high[axis] = std::max(box.high[axis], p[axis]);
            }
        }
    }
    return box;
}

std::vector<std::uint32_t> surface_of_triangles(const Scene& scene) {
    std::vector<std::uint32_t> surface_of(scene.triangles.size());
    for (std::uint32_t s = 0; s < scene.surfaces.size(); ++s) {
        const Surface& surface = scene.surfaces[s];
        std::fill_n(surface_of.begin() + surface.first_triangle, surface.triangle_count, s);
    }
    return surface_of;
}

}  // namespace lumenfarm
