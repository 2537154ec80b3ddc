#include "master/set_sizer.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <cmath>

namespace lumenfarm {

namespace {

constexpr double newest_weight = 0.5;  ///< of the newest measurement in the moving average

}  // namespace

void Pace::learn(std::uint64_t particles, double trace_s) {
    if (particles == 0 || !std::isfinite(trace_s) || trace_s <= 0) return;
    const double measured = static_cast<double>(particles) / trace_s;
    particles_per_s_ = known() ? particles_per_s_ + newest_weight * (measured - particles_per_s_) : measured;
}

std::uint64_t next_set_size(const SetPolicy& policy, const Pace& pace, std::uint64_t unleased, std::uint64_t threads) {
    ensure(threads > 0, "a farm that pulls has threads");
    if (policy.particles_per_set > 0) return std::min(policy.particles_per_set, limits::particles_per_set_max);
    if (!pace.known()) return limits::first_set_particles;
    const double wanted =
        std::min(pace.particles_per_s() * policy.target_seconds, static_cast<double>(limits::particles_per_set_max));
    const std::uint64_t guided = std::max(unleased / (2 * threads), limits::last_set_particles);
    return std::clamp(static_cast<std::uint64_t>(wanted), limits::last_set_particles, guided);
}

}  // namespace lumenfarm
