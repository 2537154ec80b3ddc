#pragma once

#include "common/math/philox.h"
#include "common/scene/job_spec.h"
#include "common/transport/bsdf.h"
#include "common/transport/flight.h"
#include "common/transport/launch.h"
#include "common/transport/meeting_points.h"
#include "common/transport/ray_query.h"
#include "common/transport/scatter_draws.h"
#include "common/transport/tracer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

/// One step of a particle's life: where it is met, what is recorded, how it goes on.
namespace lumenfarm {

/// Particles in flight, a lane each.
struct Flights {
    RayLanes rays;
    Lanes<std::uint32_t> particle{};
    Lanes<std::uint32_t> bounce{};
    Lanes<std::uint32_t> wavelength{};
    Lanes<std::uint32_t> energy{};        ///< ticks now
    Lanes<std::uint32_t> start_energy{};  ///< ticks at the light

    Flights() { rays.direction.z.fill(1); }  // lanes that never fly are computed, too

    /// As a ray that has begun somewhere else; from_triangle is this tracer's.
    void set(std::size_t lane, const Flight& flight) {
        rays.origin.set(lane, flight.origin);
        rays.direction.set(lane, flight.direction);
        rays.from_triangle[lane] = flight.from_triangle;
        rays.clear_start[lane] = false;
        particle[lane] = flight.particle;
        bounce[lane] = flight.bounce;
        wavelength[lane] = flight.wavelength;
        energy[lane] = flight.energy;
        start_energy[lane] = flight.start_energy;
    }
    /// At the start of its ray; from_triangle is this tracer's.
    Flight at(std::size_t lane) const {
        return {rays.origin.at(lane),
                rays.direction.at(lane),
                0,
                rays.from_triangle[lane],
                particle[lane],
                bounce[lane],
                wavelength[lane],
                energy[lane],
                start_energy[lane]};
    }

    void move(std::size_t to, std::size_t from) {
        rays.origin.set(to, rays.origin.at(from));
        rays.direction.set(to, rays.direction.at(from));
        rays.from_triangle[to] = rays.from_triangle[from];
        rays.clear_start[to] = rays.clear_start[from];
        particle[to] = particle[from];
        bounce[to] = bounce[from];
        wavelength[to] = wavelength[from];
        energy[to] = energy[from];
        start_energy[to] = start_energy[from];
    }
};

/// What a step needs of all lanes, made side by side.
struct Step {
    MeetingLanes meetings;
    MeetingPoints points;
    ScatterDraws draws;
};

/// The rules of a job, over a scene. Stateless: everything is drawn from (seed, light, particle, bounce).
class PathRules {
public:
    /// `surfaces`: the material of each.
    PathRules(const MaterialTable& materials, const std::vector<TriangleRecord>& triangles,
              const std::vector<const Material*>& surfaces, const JobSpec& spec, std::uint32_t light)
        : materials_(&materials),
          triangles_(triangles.data()),
          surfaces_(surfaces.data()),
          spec_(&spec),
          light_(light) {}

    /// Sets a lane to a particle at its light; books what it emits.
    void start(Flights& flights, std::size_t lane, std::uint32_t particle, const LaunchLanes& launched,
               std::size_t launched_lane, EnergyBalance& balance) const;
    /// Finds points and draws; lanes that are not in flight hold numbers without meaning. REQUIRES: step.meetings are
    /// those of flights.rays.
    void prepare(const Flights& flights, Step& step) const;
    /// Takes a particle on from what its ray meets: books, records, and either sets the next ray (true) or ends the
    /// path (false).
    bool advance(Flights& flights, std::size_t lane, const Step& step, TracedHits& hits) const;

private:
    void record(const Flights& flights, std::size_t lane, const Step& step, TracedHits& hits) const;
    /// True: the particle goes on with the lobe's direction. Books what ends.
    bool survive(Flights& flights, std::size_t lane, const Lobes& lobes, double chance, double rounding,
                 EnergyBalance& balance, Lobes::Kind& kind) const;
    bool survive_analog(std::uint32_t energy, const Lobes& lobes, double chance, EnergyBalance& balance,
                        Lobes::Kind& kind) const;
    bool survive_attenuated(Flights& flights, std::size_t lane, const Lobes& lobes, double chance, double rounding,
                            EnergyBalance& balance, Lobes::Kind& kind) const;
    bool pass_cutoff(Flights& flights, std::size_t lane, EnergyBalance& balance) const;

    const MaterialTable* materials_;
    const TriangleRecord* triangles_;
    const Material* const* surfaces_;
    const JobSpec* spec_;
    std::uint32_t light_;
};

inline void PathRules::start(Flights& flights, std::size_t lane, std::uint32_t particle, const LaunchLanes& launched,
                             std::size_t launched_lane, EnergyBalance& balance) const {
    const std::uint32_t energy = launched.energy[launched_lane];
    book_emission(balance, particle, energy);
    flights.rays.origin.set(lane, launched.rays.origin.at(launched_lane));
    flights.rays.direction.set(lane, launched.rays.direction.at(launched_lane));
    flights.rays.from_triangle[lane] = launched.rays.from_triangle[launched_lane];
    flights.rays.clear_start[lane] = launched.rays.clear_start[launched_lane];
    flights.particle[lane] = particle;
    flights.bounce[lane] = 0;
    flights.wavelength[lane] = launched.wavelength[launched_lane];
    flights.energy[lane] = flights.start_energy[lane] = energy;
}

inline void PathRules::prepare(const Flights& flights, Step& step) const {
    step.points.find(triangles_, flights.rays, step.meetings);
    step.draws.draw(spec_->seed, flights.particle, light_, flights.bounce, step.points.normal);
}

inline void PathRules::record(const Flights& flights, std::size_t lane, const Step& step, TracedHits& hits) const {
    const MeetingPoints& points = step.points;
    hits.records.push_back(
        {step.meetings.triangle[lane], static_cast<std::uint16_t>(points.packed_b1[lane]),
         static_cast<std::uint16_t>(points.packed_b2[lane]), static_cast<std::uint16_t>(points.direction_u[lane]),
         static_cast<std::uint16_t>(points.direction_v[lane]), static_cast<std::uint16_t>(flights.wavelength[lane]),
         hit_flags(flights.bounce[lane], batch_of(flights.particle[lane]), points.back[lane])});
    ++hits.balance.hits;
    if (spec_->absorption == Absorption::attenuate) hits.energies.push_back(flights.energy[lane]);
}

inline bool PathRules::advance(Flights& flights, std::size_t lane, const Step& step, TracedHits& hits) const {
    EnergyBalance& balance = hits.balance;
    const std::uint32_t met = step.meetings.triangle[lane];
    if (met == none) {
        balance.escaped += flights.energy[lane];
        return false;
    }
    record(flights, lane, step, hits);

    // choose how it goes on
    const MeetingPoints& points = step.points;
    Incidence incidence{flights.rays.direction.at(lane), points.normal.at(lane),   points.cos_incident[lane],
                        points.back[lane] != 0,          flights.wavelength[lane], {}};
    if (materials_->textured()) incidence.uv = materials_->uv_at(met, points.b1[lane], points.b2[lane]);
    double chance = step.draws.choice(lane);
    const Lobes lobes = choose_lobes(*materials_, *surfaces_[step.points.surface(lane)], incidence, chance);
    Lobes::Kind kind{};
    if (!survive(flights, lane, lobes, chance, step.draws.rounding(lane), balance, kind)) return false;
    if (++flights.bounce[lane] == limits::bounces_max) {
        balance.cut_off += flights.energy[lane];
        ++balance.bounce_limited;
        return false;
    }

    // leave
    const Vec3d direction =
        kind == Lobes::Kind::lambert ? step.draws.cosine_direction(lane) : specular_direction(lobes, kind, incidence);
    const double cos_leaving = std::abs(dot(direction, incidence.normal));
    flights.rays.origin.set(lane, points.position.at(lane));
    flights.rays.direction.set(lane, direction);
    flights.rays.from_triangle[lane] = met;
    flights.rays.clear_start[lane] = step.meetings.clear[lane] != 0 && cos_leaving >= RayQuery::steep_cosine;
    return true;
}

inline bool PathRules::survive(Flights& flights, std::size_t lane, const Lobes& lobes, double chance, double rounding,
                               EnergyBalance& balance, Lobes::Kind& kind) const {
    return spec_->absorption == Absorption::analog
               ? survive_analog(flights.energy[lane], lobes, chance, balance, kind)
               : survive_attenuated(flights, lane, lobes, chance, rounding, balance, kind);
}

inline bool PathRules::survive_analog(std::uint32_t energy, const Lobes& lobes, double chance, EnergyBalance& balance,
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
    balance.absorbed += energy;
    return false;
}

inline bool PathRules::survive_attenuated(Flights& flights, std::size_t lane, const Lobes& lobes, double chance,
                                          double rounding, EnergyBalance& balance, Lobes::Kind& kind) const {
    // energy shrinks by the albedo, rounded up or down by chance so that its expectation is exact
    const std::uint32_t before = flights.energy[lane];
    const double left = before * std::min(lobes.albedo(), 1.0) + rounding;
    const auto energy = std::min(static_cast<std::uint32_t>(left), before);
    balance.absorbed += before - energy;
    flights.energy[lane] = energy;
    if (energy == 0) return false;
    kind = chance * lobes.albedo() < lobes.first ? lobes.first_kind : lobes.second_kind;
    return pass_cutoff(flights, lane, balance);
}

inline bool PathRules::pass_cutoff(Flights& flights, std::size_t lane, EnergyBalance& balance) const {
    const std::uint32_t energy = flights.energy[lane];
    const auto threshold = static_cast<std::uint32_t>(std::ceil(spec_->cutoff * flights.start_energy[lane]));
    if (energy >= threshold) return true;
    const auto passes = [&] {
        const auto draws = philox(spec_->seed, {flights.particle[lane], light_, flights.bounce[lane], roulette_block});
        return uniform(draws[0]) * threshold < energy;
    };
    if (spec_->cutoff_rule == CutoffRule::roulette && passes()) {
        // the survivor carries the energy of those that end; both are booked as cut off, in expectation zero
        balance.cut_off -= static_cast<std::int64_t>(threshold) - energy;
        flights.energy[lane] = threshold;
        return true;
    }
    balance.cut_off += energy;
    return false;
}

}  // namespace lumenfarm
