#include "common/transport/launch.h"

#include "common/math/philox.h"

namespace lumenfarm {
namespace {

/// Counter words that no bounce uses: they give the scrambles of a light's Sobol points.
constexpr std::uint32_t scramble_bounce = 0xffffffffu;

}  // namespace

Launcher::Launcher(const Scene& scene, const Emission& emission, const RayQuery& query, std::uint64_t seed,
                   std::uint32_t light)
    : scene_(&scene),
      light_(&scene.lights[light]),
      emission_(&emission.lights[light]),
      triangles_(query.triangles().data()),
      clearance_(&query.clearance()),
      extent_(query.extent()),
      clear_light_(query.clearance().lights()[light]) {
    const auto low = philox(seed, {0, light, scramble_bounce, 0});
    const auto high = philox(seed, {0, light, scramble_bounce, 1});
    scramble_ = {low[0], low[1], low[2], low[3], high[0], high[1]};
}

}  // namespace lumenfarm
