#include "proto/messages_result.h"

#include "common/spectrum/spectrum.h"

#include <algorithm>

namespace lumenfarm::wire {

bool ResultHits::valid() const {
    if (part.sequence >= limits::parts_per_result_max || light >= limits::lights_max || records.empty()) return false;
    if (!energies.empty() && energies.size() != records.size()) return false;
    return std::ranges::all_of(energies, [](std::uint32_t ticks) { return ticks <= limits::energy_ticks_max; });
}

bool ResultMap::valid() const {
    return part.sequence < limits::parts_per_result_max && !(texels.empty() && surfaces.empty());
}

bool ResultKept::valid() const {
    const auto possible = [](const KeptHit& hit) {
        return hit.light < limits::lights_max && hit.energy <= limits::energy_ticks_max;
    };
    return part.sequence < limits::parts_per_result_max && !hits.empty() && std::ranges::all_of(hits, possible);
}

bool ResultFlights::valid() const {
    return part.sequence < limits::parts_per_result_max && subspace < limits::subspaces_max && !flights.empty() &&
           std::ranges::all_of(flights, possible_flight);
}

bool ResultWork::valid() const {
    const auto possible = [](const SubspaceWork& each) {
        return each.subspace < limits::subspaces_max && each.hits <= limits::hits_per_map_max &&
               each.nanoseconds <= work_nanoseconds_max;
    };
    const auto not_ascending = [](const SubspaceWork& a, const SubspaceWork& b) { return a.subspace >= b.subspace; };
    return part.sequence < limits::parts_per_result_max && !work.empty() && std::ranges::all_of(work, possible) &&
           std::ranges::adjacent_find(work, not_ascending) == work.end();
}

bool ResultDone::valid() const {
    const auto possible = [](double seconds) { return seconds >= 0 && seconds <= limits::result_seconds_max; };
    if (claims.empty() || parts > limits::parts_per_result_max) return false;
    if (!possible(trace_seconds) || !possible(cpu_seconds)) return false;
    // The sum can't overflow: claims_per_result_max * particles_per_set_max < 2^64.
    std::uint64_t particles = 0;
    for (const auto& claim : claims) {
        if (!valid_range(claim.range)) return false;
        particles += claim.range.count;
    }
    return balance.particles <= particles && balance_possible(balance);
}

bool balance_possible(const EnergyBalance& balance) {
    constexpr auto emitted_max = static_cast<std::int64_t>(limits::particles_max * limits::energy_ticks_max);
    // Roulette may give a particle more than it started with; three such sums still fit int64.
    constexpr std::int64_t sum_max = std::int64_t{1} << 60;
    static_assert(emitted_max < sum_max);
    const auto possible = [](std::int64_t ticks) { return ticks >= -sum_max && ticks <= sum_max; };
    if (balance.particles > limits::particles_max || balance.hits > limits::particles_max * limits::bounces_max)
        return false;
    if (balance.bounce_limited > balance.hits || balance.emitted < 0) return false;
    if (!possible(balance.absorbed) || !possible(balance.escaped) || !possible(balance.cut_off)) return false;
    std::int64_t by_batch = 0;
    for (const auto emitted : balance.emitted_by_batch) {
        if (emitted < 0 || emitted > emitted_max) return false;
        by_batch += emitted;
    }
    return by_batch == balance.emitted;
}

}  // namespace lumenfarm::wire
