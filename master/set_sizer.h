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
    /// A set is given out before the pace is known.
    void give() { ++given_; }
    std::uint64_t given() const { return given_; }

private:
    double particles_per_s_ = 0;
    std::uint64_t given_ = 0;
};

/// The farm, and the worker that asks.
struct SetDemand {
    std::uint64_t unleased = 0;        ///< particles
    std::uint64_t farm_threads = 1;    ///< > 0
    std::uint64_t worker_threads = 1;  ///< > 0
    double light_cost = 1;             ///< predicted, of a particle of the light, times the mean; > 0
};

/// Fixed: the fixed number. Automatic: while the pace is unknown as many as should take the time of
/// limits::first_set_particles of mean cost, and twice as many whenever the worker has been given two sets a thread, so
/// that a set takes no longer than all before it; then what the thread traces in target_seconds. At most the part 1 /
/// (2 x threads) of what is unleased (guided self-scheduling, Polychronopoulos and Kuck 1987), down to what takes the
/// thread last_set_part of target_seconds, and to limits::last_set_particles.
std::uint64_t next_set_size(const SetPolicy& policy, const Pace& pace, const SetDemand& demand);
inline constexpr double last_set_part = 0.005;

}  // namespace lumenfarm
