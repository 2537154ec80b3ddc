#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"

#include <span>
#include <vector>

namespace lumenfarm::import {

/// True when the triangles bound a volume: with equal positions taken as one vertex, every edge is used exactly once in
/// each direction.
bool is_closed(std::span<const Vec3d> positions, std::span<const Triangle> triangles);

/// Triangles of a simple polygon with these corners, in its own winding: a fan where it is convex, else ears
/// [Meisters 1975]. Indices are into `corners`. REQUIRES: at least three corners.
std::vector<Triangle> triangulate(std::span<const Vec3d> corners);

}  // namespace lumenfarm::import
