#include "master/staged_result.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace lumenfarm {

namespace {

/// Whether hits that add `most` each can give the sum. What is possible of two is so of their sum.
bool within(std::uint64_t sum, std::uint64_t hits, std::uint64_t most) {
    return sum / most + (sum % most > 0 ? 1 : 0) <= hits;
}

/// A sum over `hits` hits can't pass hits x energy_ticks_max x 2: no CIE ratio reaches 2. [law 3]
bool possible_sum(std::int64_t sum, std::uint64_t hits) {
    return sum >= 0 && within(static_cast<std::uint64_t>(sum), hits, 2 * limits::energy_ticks_max);
}

constexpr std::uint64_t y_squared_of_a_hit_max = std::uint64_t{(2 * limits::energy_ticks_max) >> y_squared_shift} *
                                                 ((2 * limits::energy_ticks_max) >> y_squared_shift);

bool possible(const wire::TexelDelta& delta, std::uint64_t texels) {
    return delta.texel < texels && delta.hits > 0 && possible_sum(delta.radiant, delta.hits) &&
           possible_sum(delta.x, delta.hits) && possible_sum(delta.y, delta.hits) &&
           possible_sum(delta.z, delta.hits) && within(delta.y_squared, delta.hits, y_squared_of_a_hit_max);
}

bool possible(const wire::SurfaceDelta& delta, std::uint64_t surfaces) {
    return delta.surface < surfaces && delta.side_batch < 2 * limits::batches &&
           delta.hits <= limits::particles_max * limits::bounces_max && possible_sum(delta.radiant, delta.hits) &&
           possible_sum(delta.y, delta.hits);
}

/// Bounds from the limits of a path, tight enough that no sum of a job's balances leaves int64. `covered`: particles
/// that were followed, from their light or in flight.
bool possible_balance(const EnergyBalance& balance, std::uint64_t covered) {
    if (covered > limits::particles_max || balance.hits > covered * limits::bounces_max) return false;
    const auto possible_energy = [](std::int64_t sum, std::uint64_t events) {
        constexpr std::int64_t most = std::int64_t{1} << 60;
        return sum >= -most && sum <= most &&
               within(static_cast<std::uint64_t>(std::abs(sum)), events, limits::energy_ticks_max);
    };
    std::int64_t by_batch = 0;
    for (const std::int64_t emitted : balance.emitted_by_batch) {
        if (emitted < 0 || !possible_energy(emitted, balance.particles)) return false;
        by_batch += emitted;
    }
    const std::uint64_t events = covered + balance.hits;
    return balance.emitted == by_batch && balance.absorbed >= 0 && possible_energy(balance.absorbed, events) &&
           balance.escaped >= 0 && possible_energy(balance.escaped, events) &&
           possible_energy(balance.cut_off, events) && balance.bounce_limited <= covered;
}

bool possible(const wire::FlightRecord& flight, const PreparedJob& prepared) {
    return wire::possible_flight(flight) && flight.light < prepared.particles.size() &&
           flight.particle < prepared.particles[flight.light] &&
           (flight.from_triangle == none || flight.from_triangle < prepared.scene.triangles.size());
}

}  // namespace

void StagedResult::refuse(std::string sentence) {
    if (fault_.empty()) fault_ = std::move(sentence);
    messages_.clear();
    bytes_ = 0;
}

void StagedResult::refuse_blamelessly(std::string sentence) {
    blameless_ = blameless_ || fault_.empty();
    refuse(std::move(sentence));
}

bool StagedResult::next_part(const wire::PartId& part, std::size_t part_bytes) {
    const std::uint32_t expected = parts_++;
    if (!fault_.empty()) return false;
    if (part.sequence != expected) {
        refuse("part " + std::to_string(part.sequence) + " came where part " + std::to_string(expected) + " is due");
        return false;
    }
    bytes_ += part_bytes;
    return true;
}

void StagedResult::add(const JobSpec& spec, const PreparedJob& prepared, wire::ResultHits part) {
    if (!next_part(part.part, part.records.size() * sizeof(HitRecord) + part.energies.size() * 4)) return;
    const std::size_t energies = spec.absorption == Absorption::analog ? 0 : part.records.size();
    if (part.light >= prepared.particles.size()) return refuse("light " + std::to_string(part.light) + " is not there");
    if (part.energies.size() != energies)
        return refuse(std::to_string(part.energies.size()) + " energies came with " +
                      std::to_string(part.records.size()) + " hits");
    for (const HitRecord& record : part.records)
        if (!valid_record(record, prepared.scene))
            return refuse("a hit lies outside the scene, on triangle " + std::to_string(record.triangle));
    for (const std::uint32_t energy : part.energies)
        if (energy > limits::energy_ticks_max) return refuse("a hit has " + std::to_string(energy) + " ticks");
    record_hits_ += part.records.size();
    messages_.emplace_back(std::move(part));
}

void StagedResult::add(const JobSpec&, const PreparedJob& prepared, wire::ResultMap part) {
    if (!next_part(part.part,
                   part.texels.size() * sizeof(wire::TexelDelta) + part.surfaces.size() * sizeof(wire::SurfaceDelta)))
        return;
    for (const wire::TexelDelta& delta : part.texels) {
        if (!possible(delta, prepared.layout.texel_count()))
            return refuse("texel " + std::to_string(delta.texel) + " has impossible sums");
        texel_hits_ += delta.hits;
    }
    for (const wire::SurfaceDelta& delta : part.surfaces) {
        if (!possible(delta, prepared.scene.surfaces.size()))
            return refuse("surface " + std::to_string(delta.surface) + " has impossible sums");
        surface_hits_ += delta.hits;
    }
    messages_.emplace_back(std::move(part));
}

void StagedResult::add(const JobSpec&, const PreparedJob& prepared, wire::ResultKept part) {
    if (!next_part(part.part, part.hits.size() * sizeof(KeptHit))) return;
    for (const KeptHit& hit : part.hits)
        if (hit.light >= prepared.particles.size() || hit.energy > limits::energy_ticks_max ||
            !valid_record(hit.record, prepared.scene))
            return refuse("a kept hit lies outside the scene, on triangle " + std::to_string(hit.record.triangle));
    messages_.emplace_back(std::move(part));
}

void StagedResult::add(const JobSpec&, const PreparedJob& prepared, wire::ResultFlights part) {
    if (!next_part(part.part, part.flights.size() * sizeof(wire::FlightRecord))) return;
    const std::size_t subspaces = prepared.sources() - prepared.particles.size();
    if (part.subspace >= subspaces)
        return refuse("particles go on in subspace " + std::to_string(part.subspace) + " of " +
                      std::to_string(subspaces));
    for (const wire::FlightRecord& flight : part.flights) {
        if (!possible(flight, prepared))
            return refuse("particle " + std::to_string(flight.particle) + " of light " + std::to_string(flight.light) +
                          " flies in an impossible way");
        departed_ += flight.energy;
    }
    departures_ += part.flights.size();
    messages_.emplace_back(std::move(part));
}

void StagedResult::add(const JobSpec&, const PreparedJob& prepared, wire::ResultWork part) {
    if (!next_part(part.part, part.work.size() * sizeof(SubspaceWork))) return;
    const std::size_t subspaces = prepared.sources() - prepared.particles.size();
    for (const SubspaceWork& each : part.work) work_hits_ += each.hits;
    // subspaces ascend
    if (const std::uint32_t last = part.work.back().subspace; last >= subspaces)
        return refuse("there was work in subspace " + std::to_string(last) + " of " + std::to_string(subspaces));
    messages_.emplace_back(std::move(part));
}

Result<void> StagedResult::complete(const PreparedJob& prepared, wire::ResultDone done) {
    if (auto checked = check(prepared, done); !checked) return checked;
    messages_.emplace_back(std::move(done));
    return {};
}

bool StagedResult::closes_with(std::int64_t entered) const {
    const EnergyBalance& balance = done().balance;
    return balance.emitted + entered == balance.absorbed + balance.escaped + balance.cut_off + departed_;
}

Result<void> StagedResult::check(const PreparedJob& prepared, const wire::ResultDone& done) const {
    if (!fault_.empty()) return failed(fault_);
    if (done.parts != parts_) return failed(std::to_string(parts_) + " parts arrived of " + std::to_string(done.parts));
    std::uint64_t covered = 0, particles = 0;
    for (const wire::Claim& claim : done.claims) {
        covered += claim.range.count;
        if (claim.range.source < prepared.particles.size()) particles += claim.range.count;
    }
    if (!possible_balance(done.balance, covered) || (!prepared.subspaces && !done.balance.closed()))
        return failed("the energy balance does not close");
    if (departures_ > covered)
        return failed(std::to_string(departures_) + " particles go on of " + std::to_string(covered));
    if (particles != done.balance.particles)
        return failed("the balance is of " + std::to_string(done.balance.particles) + " particles, the leases of " +
                      std::to_string(particles));
    if (work_hits_ > done.balance.hits)
        return failed("the work is of " + std::to_string(work_hits_) + " hits, the balance of " +
                      std::to_string(done.balance.hits));
    if (texel_hits_ > limits::hits_per_map_max)
        return failed("a map of " + std::to_string(texel_hits_) + " hits came; it is sent before it has so many");
    const std::uint64_t texel_hits = record_hits_ + texel_hits_, surface_hits = record_hits_ + surface_hits_;
    if (texel_hits != done.balance.hits || surface_hits != done.balance.hits)
        return failed("the balance is of " + std::to_string(done.balance.hits) + " hits, the texels of " +
                      std::to_string(texel_hits) + ", the surfaces of " + std::to_string(surface_hits));
    if (prepared.subspaces) return {};  // hits of flights are of any light
    for (const wire::Message& message : messages_) {
        const auto* part = std::get_if<wire::ResultHits>(&message);
        const auto of_light = [&](const wire::Claim& claim) { return claim.range.source == part->light; };
        if (part && std::none_of(done.claims.begin(), done.claims.end(), of_light))
            return failed("hits of light " + std::to_string(part->light) + " came without a lease of it");
    }
    return {};
}

}  // namespace lumenfarm
