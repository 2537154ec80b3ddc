#include "worker/worker_core.h"

#include <algorithm>

/// The worker's core, looked through: what it holds is bounded.
namespace lumenfarm::worker {

std::optional<std::string> WorkerCore::contradiction() const {
    // a slot starts while there is room for its result, and each slot may be the last to find it
    const std::size_t results_max = 2 * slots_.size() + largest_credit_;
    if (results_.size() > results_max)
        return std::to_string(results_.size()) + " results are held, more than " + std::to_string(results_max);
    std::size_t sets = queue_.size();
    for (const Slot& slot : slots_) sets += slot.lease.has_value();
    if (sets > limits::leases_per_worker_max) return std::to_string(sets) + " sets are held, more than may be";
    return std::nullopt;
}

}  // namespace lumenfarm::worker
