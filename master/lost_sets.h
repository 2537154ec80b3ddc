#pragma once

#include "common/transport/tracer.h"

#include <cstdint>
#include <optional>
#include <vector>

/// Particles whose workers were lost while they had them. They are given out again after a wait that doubles with each
/// loss. What was lost twice goes only to a worker that has nothing else in hand, so that a set that kills workers is
/// told from sets that were lost beside it. What limits::losses_max workers were lost with is set aside; it may be
/// tried again when nothing else is left, since workers also die of other things. A worker that comes back was not
/// killed.
namespace lumenfarm {

struct LostSet {
    ParticleRange range;
    std::vector<std::uint64_t> lost_with;  ///< processes of workers
    std::uint32_t retries = 0;             ///< after it was set aside
    double ready_s = 0;
    bool alone() const { return lost_with.size() > 1; }
};

class LostSets {
public:
    void add(LostSet lost, double now_s);
    /// What was set aside waits for another try, longer each time. False: limits::set_aside_retries were too many.
    bool retry_set_aside(double now_s);
    /// The worker is there again: what was lost with it is less suspect.
    void forgive(std::uint64_t worker, double now_s);

    /// Whether take() has one.
    bool ready(double now_s, bool alone) const;
    /// Whether take() has one, but only for a worker that has nothing in hand.
    bool needs_empty_hands(double now_s) const { return ready(now_s, true) && !ready(now_s, false); }
    /// One whose wait is over, at most `count` particles of it. `alone`: for a worker that has nothing in hand; else
    /// none that needs such a worker. REQUIRES: count > 0.
    std::optional<LostSet> take(double now_s, bool alone, std::uint64_t count);

    /// Takes all out, waiting or set aside, that are of a source below this.
    std::vector<LostSet> extract_below(std::uint32_t source);

    /// Takes out what of the range is lost.
    void remove(const ParticleRange& range);

    const std::vector<LostSet>& waiting() const { return waiting_; }
    const std::vector<LostSet>& set_aside() const { return set_aside_; }
    std::uint64_t waiting_particles() const { return particles_of(waiting_); }
    std::uint64_t set_aside_particles() const { return particles_of(set_aside_); }

private:
    static std::uint64_t particles_of(const std::vector<LostSet>& sets);

    std::vector<LostSet> waiting_;
    std::vector<LostSet> set_aside_;
};

}  // namespace lumenfarm
