#pragma once

#include "common/scene/job_spec.h"
#include "common/transport/bsdf.h"
#include "common/transport/launch.h"
#include "common/transport/ray_query.h"
#include "common/transport/tracer.h"

#include <cstdint>

/// One step of a particle's life: where it is met, what is recorded, how it goes on.
namespace lumenfarm {

/// A particle in flight.
struct Flight {
    Ray ray;
    std::uint32_t particle = 0;
    std::uint32_t bounce = 0;
    std::uint32_t wavelength = 0;
    std::uint32_t energy = 0;        ///< ticks now
    std::uint32_t start_energy = 0;  ///< ticks at the light
};

/// The rules of a job, over a scene. Stateless: everything is drawn from (seed, light, particle, bounce).
class PathRules {
public:
    PathRules(const Scene& scene, const RayQuery& query, const MaterialTable& materials, const JobSpec& spec,
              std::uint32_t light)
        : scene_(&scene), query_(&query), materials_(&materials), spec_(&spec), light_(light) {}

    /// A particle at its light; books what it emits.
    Flight start(const Launcher& launcher, std::uint32_t particle, EnergyBalance& balance) const;
    /// Takes the particle on from the triangle that its ray meets (none: it escapes); books, records, and either sets the
    /// next ray (true) or ends the path (false).
    bool advance(Flight& flight, const RayAnswer& met, TracedHits& hits) const;

private:
    /// True: the particle goes on with the lobe's direction. Books what ends.
    bool survive(Flight& flight, const Lobes& lobes, double chance, std::uint32_t bits, EnergyBalance& balance,
                 Lobes::Kind& kind) const;
    bool survive_analog(Flight& flight, const Lobes& lobes, double chance, EnergyBalance& balance, Lobes::Kind& kind) const;
    bool survive_attenuated(Flight& flight, const Lobes& lobes, double chance, std::uint32_t bits, EnergyBalance& balance,
                            Lobes::Kind& kind) const;
    bool pass_cutoff(Flight& flight, EnergyBalance& balance) const;
    Vec2f uv_at(std::uint32_t triangle, double b1, double b2) const;

    const Scene* scene_;
    const RayQuery* query_;
    const MaterialTable* materials_;
    const JobSpec* spec_;
    std::uint32_t light_;
};

}  // namespace lumenfarm
