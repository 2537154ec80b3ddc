#include "master/set_sizer.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <cmath>

namespace lumenfarm {

namespace {

constexpr double newest_weight = 0.5;        ///< of the newest measurement in the moving average
constexpr std::uint64_t doublings_max = 15;  ///< of a worker's first sets: to about particles_per_set_max
static_assert(limits::first_set_particles << doublings_max <= limits::particles_per_set_max);

}  // namespace

void Pace::learn(std::uint64_t particles, double trace_s) {
    if (particles == 0 || !std::isfinite(trace_s) || trace_s <= 0) return;
    const double measured = static_cast<double>(particles) / trace_s;
    particles_per_s_ = known() ? particles_per_s_ + newest_weight * (measured - particles_per_s_) : measured;
}

std::uint64_t next_set_size(const SetPolicy& policy, const Pace& pace, const SetDemand& demand) {
    ensure(demand.farm_threads > 0 && demand.worker_threads > 0, "a farm that pulls has threads");
    if (policy.particles_per_set > 0) return std::min(policy.particles_per_set, limits::particles_per_set_max);
    constexpr auto most = static_cast<double>(limits::particles_per_set_max);
    const std::uint64_t rounds = std::min(pace.given() / (2 * demand.worker_threads), doublings_max);
    const auto first = static_cast<double>(limits::first_set_particles << rounds);
    const double aimed = pace.known() ? pace.particles_per_s() * policy.target_seconds : first / demand.light_cost;
    const auto wanted = static_cast<std::uint64_t>(std::min(aimed, most));
    const auto last = static_cast<std::uint64_t>(static_cast<double>(wanted) * last_set_part);
    const std::uint64_t guided =
        std::max({demand.unleased / (2 * demand.farm_threads), limits::last_set_particles, last});
    return std::clamp(wanted, limits::last_set_particles, guided);
}

}  // namespace lumenfarm
