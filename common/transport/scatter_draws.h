#pragma once

#include "common/math/philox.h"
#include "common/math/sampling.h"

#include <array>
#include <cstddef>
#include <cstdint>

/// What chance decides at the next bounce of many particles, made side by side: the same operations on whole arrays,
/// which the compiler turns into vector instructions.
namespace lumenfarm {

/// Paths traced side by side, so that one's memory is fetched while another computes.
inline constexpr std::size_t flights_side_by_side = 32;

/// Dimension blocks of the draws at a bounce (counter word 3).
inline constexpr std::uint32_t scatter_block = 0;
inline constexpr std::uint32_t roulette_block = 1;

class ScatterDraws {
public:
    /// The particle of a lane and its bounce; lanes that are not set draw for whatever they held.
    void set(std::size_t lane, std::uint32_t particle, std::uint32_t light, std::uint32_t bounce) {
        philox_.words[0][lane] = particle;
        philox_.words[1][lane] = light;
        philox_.words[2][lane] = bounce;
        philox_.words[3][lane] = scatter_block;
    }
    /// Draws for all lanes.
    void draw(std::uint64_t seed) {
        philox_.draw(seed);
        for (std::size_t k = 0; k < flights_side_by_side; ++k) {
            const Vec3d local = sample_cosine_hemisphere(uniform(philox_.words[1][k]), uniform(philox_.words[2][k]));
            x_[k] = local.x;
            y_[k] = local.y;
            z_[k] = local.z;
        }
    }
    double choice(std::size_t lane) const { return uniform(philox_.words[0][lane]); }
    double rounding(std::size_t lane) const { return uniform(philox_.words[3][lane]); }
    /// About +z, density cos(theta) / pi.
    Vec3d cosine_direction(std::size_t lane) const { return {x_[lane], y_[lane], z_[lane]}; }

private:
    PhiloxLanes<flights_side_by_side> philox_{};
    alignas(64) std::array<double, flights_side_by_side> x_{}, y_{}, z_{};
};

}  // namespace lumenfarm
