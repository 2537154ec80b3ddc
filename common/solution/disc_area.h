#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"

#include <cstdint>

namespace lumenfarm {

/// Area of the part of a triangle that lies within `radius_m` of a point in space: the cut of a disc and a triangle,
/// exact [sums of circular sectors and triangles along the edges].
double area_within_m2(const Scene& scene, std::uint32_t triangle, Vec3d centre, double radius_m);

}  // namespace lumenfarm
