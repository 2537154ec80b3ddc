#pragma once

#include "common/transport/hit.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <optional>
#include <vector>

/// The path of one particle, as the product's tracer takes it.
namespace lumenfarm {

enum class HitFate : std::uint8_t { reflected, transmitted, absorbed, cut_off, bounce_limit };

/// Energies in ticks.
struct PathHit {
    HitRecord record;  ///< to the bit what a worker sends
    std::uint32_t surface = 0;
    Vec3d direction;           ///< of travel before the hit, unit
    std::uint32_t energy = 0;  ///< before the hit
    std::int64_t absorbed = 0;
    std::int64_t cut_off = 0;  ///< negative where roulette gave a survivor more
    HitFate fate = HitFate::absorbed;
};

struct TracedPath {
    std::uint64_t particle = 0;
    std::uint32_t wavelength = 0;  ///< bin
    std::uint32_t energy = 0;      ///< ticks at the light
    Vec3d position;                ///< at the light [m]
    Vec3d direction;               ///< of travel from there, unit
    std::vector<PathHit> hits;
    std::optional<Vec3d> escaped;  ///< the direction in which it left the scene
    EnergyBalance balance;
};

/// How many particles a job has in all makes no difference to the path of one. REQUIRES: as TracerScene::trace().
TracedPath trace_path(const TracerScene& tracer, const JobSpec& spec, std::uint32_t light, std::uint64_t particle);

}  // namespace lumenfarm
