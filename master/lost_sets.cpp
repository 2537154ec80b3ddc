#include "master/lost_sets.h"

#include "common/support/ensure.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lumenfarm {

void LostSets::add(const ParticleRange& range, std::uint32_t losses, double now_s) {
    if (losses >= limits::losses_max) return set_aside_.push_back(range);
    waiting_.push_back({range, losses, now_s + limits::retry_seconds * std::exp2(losses - 1)});
}

bool LostSets::ready(double now_s, bool alone) const {
    return std::any_of(waiting_.begin(), waiting_.end(),
                       [&](const LostSet& lost) { return lost.ready_s <= now_s && (alone || !lost.alone()); });
}

std::optional<LostSet> LostSets::take(double now_s, bool alone, std::uint64_t count) {
    ensure(count > 0, "a set is not empty");
    const auto found = std::find_if(waiting_.begin(), waiting_.end(), [&](const LostSet& lost) {
        return lost.ready_s <= now_s && (alone || !lost.alone());
    });
    if (found == waiting_.end()) return std::nullopt;
    LostSet taken = *found;
    taken.range.count = std::min(taken.range.count, count);
    found->range.first += taken.range.count;
    found->range.count -= taken.range.count;
    if (found->range.count == 0) waiting_.erase(found);
    return taken;
}

std::uint64_t LostSets::waiting_particles() const {
    return std::accumulate(waiting_.begin(), waiting_.end(), std::uint64_t{0},
                           [](std::uint64_t sum, const LostSet& lost) { return sum + lost.range.count; });
}

std::uint64_t LostSets::set_aside_particles() const {
    return std::accumulate(set_aside_.begin(), set_aside_.end(), std::uint64_t{0},
                           [](std::uint64_t sum, const ParticleRange& range) { return sum + range.count; });
}

}  // namespace lumenfarm
