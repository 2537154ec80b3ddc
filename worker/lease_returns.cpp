#include "worker/lease_returns.h"

#include <algorithm>
#include <cstddef>

namespace lumenfarm::worker {

std::vector<wire::ReturnLeases> LeaseReturns::take(const Claimed& claimed) {
    std::vector<wire::ReturnLeases> messages;
    for (auto& [reason, leases] : waiting_) {
        const auto ready = std::partition(leases.begin(), leases.end(),
                                          [&](const wire::LeaseRef& lease) { return claimed(lease.lease); });
        for (auto next = ready; next != leases.end();) {
            const auto count = std::min<std::ptrdiff_t>(leases.end() - next, limits::leases_per_worker_max);
            messages.emplace_back(reason, std::vector<wire::LeaseRef>(next, next + count));
            next += count;
        }
        leases.erase(ready, leases.end());
    }
    std::erase_if(waiting_, [](const auto& entry) { return entry.second.empty(); });
    return messages;
}

void LeaseReturns::keep_only(const Claimed& claimed) {
    for (auto& [reason, leases] : waiting_)
        std::erase_if(leases, [&](const wire::LeaseRef& lease) { return !claimed(lease.lease); });
    std::erase_if(waiting_, [](const auto& entry) { return entry.second.empty(); });
}

}  // namespace lumenfarm::worker
