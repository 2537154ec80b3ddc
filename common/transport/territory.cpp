#include "common/transport/territory.h"

#include <algorithm>
#include <utility>

namespace lumenfarm {

void Territory::emit(const JobSpec& spec, const ParticleRange& range, const Emitter& emitter, TracedHits& hits,
                     std::vector<Departure>& departures, WorkMeter* meter) const {
    if (whole_) return whole_->trace(spec, range, hits);
    std::vector<Departure> emitted;
    emitter.emit(spec.seed, range, emitted, hits.balance);
    trace_parts(spec, range.source, emitted, hits, departures, meter);
}

void Territory::trace(const JobSpec& spec, std::uint32_t light, const std::vector<Departure>& arrivals,
                      TracedHits& hits, std::vector<Departure>& departures, WorkMeter* meter) const {
    if (!whole_) return trace_parts(spec, light, arrivals, hits, departures, meter);
    std::vector<Flight> flights;
    for (const Departure& each : arrivals) flights.push_back(each.flight);
    whole_->follow(spec, light, flights, hits);
}

void Territory::trace_parts(const JobSpec& spec, std::uint32_t light, const std::vector<Departure>& arrivals,
                            TracedHits& hits, std::vector<Departure>& departures, WorkMeter* meter) const {
    std::vector<std::vector<Flight>> waiting(parts_.size());
    const auto file = [&](const std::vector<Departure>& moving) {
        for (const Departure& each : moving)
            if (holds(each.subspace))
                waiting[each.subspace].push_back(each.flight);
            else
                departures.push_back(each);
    };
    file(arrivals);
    // the fullest first, so that few are traced alone
    const auto fewer = [](const auto& a, const auto& b) { return a.size() < b.size(); };
    std::vector<Departure> leavers;
    if (meter) meter->begin();
    for (;;) {
        const auto fullest = std::max_element(waiting.begin(), waiting.end(), fewer);
        if (fullest == waiting.end() || fullest->empty()) return;
        const std::vector<Flight> flights = std::exchange(*fullest, {});
        const auto subspace = static_cast<std::uint32_t>(fullest - waiting.begin());
        const std::uint64_t hits_before = hits.balance.hits;
        leavers.clear();
        parts_[subspace]->trace(spec, light, flights, *partition_, subspace, hits, leavers);
        file(leavers);
        if (meter) meter->lap(subspace, hits.balance.hits - hits_before);
    }
}

}  // namespace lumenfarm
