#pragma once

#include "common/math/philox.h"
#include "common/math/sampling.h"
#include "common/transport/lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>

/// What chance decides at the next bounce of many particles, made side by side: the same operations on whole arrays,
/// which the compiler turns into vector instructions.
namespace lumenfarm {

/// Dimension blocks of the draws at a bounce (counter word 3).
inline constexpr std::uint32_t scatter_block = 0;
inline constexpr std::uint32_t roulette_block = 1;

class ScatterDraws {
public:
    /// Draws for all lanes, directions about these normals.
    void draw(std::uint64_t seed, const Lanes<std::uint32_t>& particle, std::uint32_t light,
              const Lanes<std::uint32_t>& bounce, const VecLanes& normals) {
        philox_.draw(seed, particle, light, bounce, scatter_block);
        for (std::size_t k = 0; k < lane_count; ++k)
            directions_.set(k, sample_cosine_about(normals.at(k), uniform_float(philox_.word(1)[k]),
                                                   uniform_float(philox_.word(2)[k])));
    }
    double choice(std::size_t lane) const { return uniform(philox_.word(0)[lane]); }
    double rounding(std::size_t lane) const { return uniform(philox_.word(3)[lane]); }
    /// Unit, density cos(theta) / pi about the lane's normal.
    Vec3d cosine_direction(std::size_t lane) const { return directions_.at(lane); }

private:
    PhiloxLanes<lane_count> philox_{};
    VecLanes directions_;
};

}  // namespace lumenfarm
