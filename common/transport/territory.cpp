#include "common/transport/territory.h"

#include <algorithm>
#include <utility>

namespace lumenfarm {

void Territory::trace(const JobSpec& spec, std::uint32_t light, const std::vector<Departure>& arrivals,
                      TracedHits& hits, std::vector<Departure>& departures) const {
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
    for (;;) {
        const auto fullest = std::max_element(waiting.begin(), waiting.end(), fewer);
        if (fullest == waiting.end() || fullest->empty()) return;
        const std::vector<Flight> flights = std::exchange(*fullest, {});
        const auto subspace = static_cast<std::uint32_t>(fullest - waiting.begin());
        leavers.clear();
        parts_[subspace]->trace(spec, light, flights, *partition_, subspace, hits, leavers);
        file(leavers);
    }
}

}  // namespace lumenfarm
