#include "common/transport/launch.h"

#include "common/math/philox.h"

namespace lumenfarm {
namespace {

/// Counter words that no bounce uses: they give the scrambles of a light's Sobol points.
constexpr std::uint32_t scramble_bounce = 0xffffffffu;

}  // namespace

Launcher::Launcher(const Scene& scene, const Emission& emission, const SceneExtent& extent,
                   const TriangleRecord* triangles, const ClearanceMap& clearance, std::uint64_t seed,
                   std::uint32_t light)
    : scene_(&scene),
      light_(&scene.lights[light]),
      emission_(&emission.lights[light]),
      triangles_(triangles),
      clearance_(&clearance),
      extent_(extent),
      clear_light_(clearance.is_clear_at_light(light)) {
    const auto low = philox(seed, {0, light, scramble_bounce, 0});
    const auto high = philox(seed, {0, light, scramble_bounce, 1});
    scramble_ = {low[0], low[1], low[2], low[3], high[0], high[1]};
}

}  // namespace lumenfarm
