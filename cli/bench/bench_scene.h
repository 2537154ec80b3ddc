#pragma once

#include "common/scene/scene.h"

#include <cstdint>

namespace lumenfarm {

/// A closed white room of 1 m with a lamp under its ceiling and hills on its floor, of about so many triangles: a large
/// scene that can be made anywhere. REQUIRES: 100 <= triangles <= limits::triangles_max.
Scene make_bench_scene(std::uint64_t triangles);

}  // namespace lumenfarm
