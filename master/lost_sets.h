#pragma once

#include "common/transport/tracer.h"

#include <cstdint>
#include <optional>
#include <vector>

/// Particles whose workers were lost while they had them. They are given out again after a wait that doubles with each
/// loss. What was lost twice goes only to a worker that has nothing else in hand, so that a set that kills workers is
/// told from sets that were lost beside it. What was lost limits::losses_max times is set aside.
namespace lumenfarm {

struct LostSet {
    ParticleRange range;
    std::uint32_t losses = 1;
    double ready_s = 0;
    bool alone() const { return losses > 1; }
};

class LostSets {
public:
    void add(const ParticleRange& range, std::uint32_t losses, double now_s);

    /// Whether take() has one.
    bool ready(double now_s, bool alone) const;
    /// One whose wait is over, at most `count` particles of it. `alone`: for a worker that has nothing in hand; else
    /// none that needs such a worker. REQUIRES: count > 0.
    std::optional<LostSet> take(double now_s, bool alone, std::uint64_t count);

    const std::vector<LostSet>& waiting() const { return waiting_; }
    std::uint64_t waiting_particles() const;
    std::uint64_t set_aside_particles() const;
    const std::vector<ParticleRange>& set_aside() const { return set_aside_; }

private:
    std::vector<LostSet> waiting_;
    std::vector<ParticleRange> set_aside_;
};

}  // namespace lumenfarm
