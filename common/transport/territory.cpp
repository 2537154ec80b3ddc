#include "common/transport/territory.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace lumenfarm {

void Territory::emit(const JobSpec& spec, const ParticleRange& range, const Emitter& emitter, std::uint64_t hits_max,
                     TracedFlights& traced, WorkMeter* meter) const {
    if (whole_) return whole_->trace(spec, range, traced.hits);
    std::vector<Departure> emitted;
    emitter.emit(spec.seed, range, emitted, traced.hits.balance);
    trace_parts(spec, range.source, emitted, hits_max, traced, meter);
}

void Territory::trace(const JobSpec& spec, std::uint32_t light, const std::vector<Departure>& arrivals,
                      std::uint64_t hits_max, TracedFlights& traced, WorkMeter* meter) const {
    if (!whole_) return trace_parts(spec, light, arrivals, hits_max, traced, meter);
    std::vector<Flight> flights;
    for (const Departure& each : arrivals) flights.push_back(each.flight);
    whole_->follow(spec, light, flights, traced.hits);
}

void Territory::trace_parts(const JobSpec& spec, std::uint32_t light, const std::vector<Departure>& arrivals,
                            std::uint64_t hits_max, TracedFlights& traced, WorkMeter* meter) const {
    std::vector<std::vector<Flight>> waiting(parts_.size());
    const auto file = [&](const std::vector<Departure>& moving) {
        for (const Departure& each : moving)
            if (holds(each.subspace))
                waiting[each.subspace].push_back(each.flight);
            else
                traced.departures.push_back(each);
    };
    file(arrivals);
    // the fullest first, so that few are traced alone
    const auto fewer = [](const auto& a, const auto& b) { return a.size() < b.size(); };
    const std::uint64_t hits_before = traced.hits.balance.hits;
    std::vector<Departure> leavers;
    if (meter) meter->begin();
    while (traced.hits.balance.hits - hits_before < hits_max) {
        const auto fullest = std::max_element(waiting.begin(), waiting.end(), fewer);
        if (fullest == waiting.end() || fullest->empty()) return;
        const auto last = fullest->end() - std::min(std::ssize(*fullest), std::ptrdiff_t{limits::flights_at_once});
        const std::vector<Flight> flights(last, fullest->end());
        fullest->erase(last, fullest->end());
        const auto subspace = static_cast<std::uint32_t>(fullest - waiting.begin());
        const std::uint64_t hits_then = traced.hits.balance.hits;
        leavers.clear();
        parts_[subspace]->trace(spec, light, flights, *partition_, subspace, traced.hits, leavers);
        file(leavers);
        if (meter) meter->lap(subspace, traced.hits.balance.hits - hits_then);
    }
    for (std::uint32_t subspace = 0; subspace < waiting.size(); ++subspace)
        for (const Flight& flight : waiting[subspace]) traced.departures.push_back({subspace, flight});
}

}  // namespace lumenfarm
