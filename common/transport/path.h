#pragma once

#include "common/math/philox.h"
#include "common/scene/job_spec.h"
#include "common/transport/bsdf.h"
#include "common/transport/launch.h"
#include "common/transport/ray_query.h"
#include "common/transport/scatter_draws.h"
#include "common/transport/tracer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

/// One step of a particle's life: where it is met, what is recorded, how it goes on.
namespace lumenfarm {

/// What a step asks of a surface, without its names.
struct SurfaceFacts {
    const Material* material;
    double near_volume;  ///< an edge volume below this may belong to a point nearer to that edge than near_edge_m()
};
/// An edge volume is the edge's length times the distance at which the ray's line passes it, if the direction is a unit
/// vector; and that distance is at most the one in the plane of the triangle.
std::vector<SurfaceFacts> surface_facts(const Scene& scene, const RayQuery& query);

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
    PathRules(const MaterialTable& materials, const std::vector<TriangleRecord>& triangles,
              const std::vector<SurfaceFacts>& surfaces, const JobSpec& spec, std::uint32_t light)
        : materials_(&materials),
          triangles_(triangles.data()),
          surfaces_(surfaces.data()),
          spec_(&spec),
          light_(light) {}

    /// A particle at its light; books what it emits.
    Flight start(const Launcher& launcher, std::uint32_t particle, EnergyBalance& balance) const;
    /// Takes the particle on from the triangle that its ray meets (none: it escapes) by the draws of its lane; books,
    /// records, and either sets the next ray (true) or ends the path (false).
    bool advance(Flight& flight, const RayAnswer& met, const ScatterDraws& draws, std::size_t lane,
                 TracedHits& hits) const;

private:
    /// True: the particle goes on with the lobe's direction. Books what ends.
    bool survive(Flight& flight, const Lobes& lobes, double chance, double rounding, EnergyBalance& balance,
                 Lobes::Kind& kind) const;
    bool survive_analog(Flight& flight, const Lobes& lobes, double chance, EnergyBalance& balance,
                        Lobes::Kind& kind) const;
    bool survive_attenuated(Flight& flight, const Lobes& lobes, double chance, double rounding, EnergyBalance& balance,
                            Lobes::Kind& kind) const;
    bool pass_cutoff(Flight& flight, EnergyBalance& balance) const;

    const MaterialTable* materials_;
    const TriangleRecord* triangles_;
    const SurfaceFacts* surfaces_;
    const JobSpec* spec_;
    std::uint32_t light_;
};

inline std::uint16_t packed_weight(double b) {
    const double scaled = b * 65536;
    return static_cast<std::uint16_t>(scaled < 65535 ? (scaled > 0 ? scaled : 0) : 65535);
}

inline Flight PathRules::start(const Launcher& launcher, std::uint32_t particle, EnergyBalance& balance) const {
    const LaunchedParticle launched = launcher.launch(particle);
    ++balance.particles;
    balance.emitted += launched.energy;
    balance.emitted_by_batch[batch_of(particle)] += launched.energy;
    Flight flight;
    flight.ray = {launched.origin, launched.direction, launched.from_triangle, true};
    flight.particle = particle;
    flight.wavelength = launched.wavelength;
    flight.energy = flight.start_energy = launched.energy;
    return flight;
}

inline bool PathRules::advance(Flight& flight, const RayAnswer& met, const ScatterDraws& draws, std::size_t lane,
                               TracedHits& hits) const {
    EnergyBalance& balance = hits.balance;
    if (met.triangle == none) {
        balance.escaped += flight.energy;
        return false;
    }
    const TriangleRecord& triangle = triangles_[met.triangle];
    const EdgeVolumes e = edge_volumes(triangle, flight.ray.origin, flight.ray.direction);
    const double scale = 1 / (e.e0 + e.e1 + e.e2);
    const double b1 = e.e1 * scale;
    const double b2 = e.e2 * scale;

    // record the hit
    const double approach = dot(triangle.normal, flight.ray.direction);
    const bool back = approach > 0;
    const OctahedralDirection direction = encode_direction(flight.ray.direction);
    hits.records.push_back({met.triangle, packed_weight(b1), packed_weight(b2), direction.u, direction.v,
                            static_cast<std::uint16_t>(flight.wavelength),
                            hit_flags(flight.bounce, batch_of(flight.particle), back)});
    ++balance.hits;
    if (spec_->absorption == Absorption::attenuate) hits.energies.push_back(flight.energy);

    // choose how it goes on
    const SurfaceFacts& surface = surfaces_[triangle.surface];
    Incidence incidence{flight.ray.direction, back ? -triangle.normal : triangle.normal,
                        std::abs(approach),   back,
                        flight.wavelength,    {}};
    if (materials_->textured()) incidence.uv = materials_->uv_at(met.triangle, b1, b2);
    double chance = draws.choice(lane);
    const Lobes lobes = choose_lobes(*materials_, *surface.material, incidence, chance);
    Lobes::Kind kind{};
    if (!survive(flight, lobes, chance, draws.rounding(lane), balance, kind)) return false;
    if (++flight.bounce == limits::bounces_max) {
        balance.cut_off += flight.energy;
        ++balance.bounce_limited;
        return false;
    }
    flight.ray.origin = point_on(triangle, b1, b2);
    flight.ray.direction = scattered_direction(lobes, kind, incidence, draws.cosine_direction(lane));
    flight.ray.from_triangle = met.triangle;
    flight.ray.near_edge = std::min({std::abs(e.e0), std::abs(e.e1), std::abs(e.e2)}) < surface.near_volume;
    return true;
}

inline bool PathRules::survive(Flight& flight, const Lobes& lobes, double chance, double rounding,
                               EnergyBalance& balance, Lobes::Kind& kind) const {
    return spec_->absorption == Absorption::analog ? survive_analog(flight, lobes, chance, balance, kind)
                                                   : survive_attenuated(flight, lobes, chance, rounding, balance, kind);
}

inline bool PathRules::survive_analog(Flight& flight, const Lobes& lobes, double chance, EnergyBalance& balance,
                                      Lobes::Kind& kind) const {
    // survive with probability albedo, energy unchanged [Arvo and Kirk 1990]
    if (chance < lobes.first) {
        kind = lobes.first_kind;
        return true;
    }
    if (chance < lobes.first + lobes.second) {
        kind = lobes.second_kind;
        return true;
    }
    balance.absorbed += flight.energy;
    return false;
}

inline bool PathRules::survive_attenuated(Flight& flight, const Lobes& lobes, double chance, double rounding,
                                          EnergyBalance& balance, Lobes::Kind& kind) const {
    // energy shrinks by the albedo, rounded up or down by chance so that its expectation is exact
    const double left = flight.energy * std::min(lobes.albedo(), 1.0) + rounding;
    const auto energy = std::min(static_cast<std::uint32_t>(left), flight.energy);
    balance.absorbed += flight.energy - energy;
    flight.energy = energy;
    if (energy == 0) return false;
    kind = chance * lobes.albedo() < lobes.first ? lobes.first_kind : lobes.second_kind;
    return pass_cutoff(flight, balance);
}

inline bool PathRules::pass_cutoff(Flight& flight, EnergyBalance& balance) const {
    const auto threshold = static_cast<std::uint32_t>(std::ceil(spec_->cutoff * flight.start_energy));
    if (flight.energy >= threshold) return true;
    const auto passes = [&] {
        const auto draws = philox(spec_->seed, {flight.particle, light_, flight.bounce, roulette_block});
        return uniform(draws[0]) * threshold < flight.energy;
    };
    if (spec_->cutoff_rule == CutoffRule::roulette && passes()) {
        // the survivor carries the energy of those that end; both are booked as cut off, in expectation zero
        balance.cut_off -= static_cast<std::int64_t>(threshold) - flight.energy;
        flight.energy = threshold;
        return true;
    }
    balance.cut_off += flight.energy;
    return false;
}

}  // namespace lumenfarm
