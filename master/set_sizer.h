#pragma once

#include "common/support/limits.h"

#include <cstdint>

/// How many particles the next set holds. The size changes the traffic and the balance of the farm, never the result.
namespace lumenfarm {

struct SetPolicy {
    std::uint64_t particles_per_set = 0;  ///< fixed; 0 is automatic
    double target_seconds = 2;            ///< automatic: a set should keep a tracing thread busy for this long
};

/// The measured speed of one tracing thread of a worker on one job.
class Pace {
public:
    /// `trace_s` is summed over threads. Nothing is learnt of an empty or timeless result.
    void learn(std::uint64_t particles, double trace_s);
    bool known() const { return particles_per_s_ > 0; }
    double particles_per_s() const { return particles_per_s_; }

private:
    double particles_per_s_ = 0;
};

/// Fixed: the fixed number. Automatic: limits::first_set_particles while the pace is unknown; then what the thread
/// traces in target_seconds, but at most the part 1 / (2 x threads) of what is unleased (guided self-scheduling,
/// Polychronopoulos and Kuck 1987), and not under limits::last_set_particles. REQUIRES: threads > 0.
std::uint64_t next_set_size(const SetPolicy& policy, const Pace& pace, std::uint64_t unleased, std::uint64_t threads);

}  // namespace lumenfarm
