#include "cli/import/default_light.h"

#include <algorithm>
#include <numbers>

namespace lumenfarm::import {
namespace {

constexpr double illuminance_goal_lx = 500;
constexpr double gap_of_height = 0.01;  ///< between the top of the scene and the light
constexpr double reflectance = 0.8;

}  // namespace

MeshPart default_light(SceneBuilder& builder) {
    const Box box = bounding_box(builder.scene());
    const Vec3d size = box.high - box.low;
    const double extent = std::max({size.x, size.y, size.z});
    const double least = extent * 0.01;  // a flat scene still gets a light with an area
    const double half_x = std::max(size.x, least) / 4;
    const double half_z = std::max(size.z, least) / 4;
    const Vec3d centre = (box.low + box.high) * 0.5;
    const double y = size.y > least ? box.high.y - size.y * gap_of_height : box.high.y + extent / 2;

    Material material;
    material.name = "default light";
    material.diffuse.spectrum = builder.add_spectrum(constant_spectrum(reflectance));
    MeshPart part;
    part.object = "default light";
    part.material.index = builder.add_material(material);
    // A Lambert emitter of luminance L and a quarter of the area A gives pi L A / 4 lumens.
    part.material.luminance = illuminance_goal_lx * 4 / std::numbers::pi;
    part.material.emission_spectrum = builder.add_light_spectrum({1, 1, 1});
    part.positions = {{centre.x - half_x, y, centre.z - half_z},
                      {centre.x + half_x, y, centre.z - half_z},
                      {centre.x + half_x, y, centre.z + half_z},
                      {centre.x - half_x, y, centre.z + half_z}};
    part.triangles = {{0, 1, 2}, {0, 2, 3}};
    return part;
}

}  // namespace lumenfarm::import
