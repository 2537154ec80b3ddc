#include "master/lost_sets.h"

#include "common/support/ensure.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace lumenfarm {

void LostSets::add(LostSet lost, double now_s) {
    const auto losses = static_cast<double>(lost.lost_with.size());
    lost.ready_s = now_s + limits::retry_seconds * std::exp2(losses - 1);
    (lost.lost_with.size() >= limits::losses_max ? set_aside_ : waiting_).push_back(std::move(lost));
}

bool LostSets::retry_set_aside(double now_s) {
    const auto may = [](const LostSet& lost) { return lost.retries < limits::set_aside_retries; };
    const auto again =
        std::partition(set_aside_.begin(), set_aside_.end(), [&](const LostSet& lost) { return !may(lost); });
    if (again == set_aside_.end()) return false;
    for (auto it = again; it != set_aside_.end(); ++it) {
        it->ready_s = now_s + limits::set_aside_seconds * std::exp2(2 * it->retries++);
        it->lost_with.resize(limits::losses_max - 1);  // the next loss sets it aside
        waiting_.push_back(std::move(*it));
    }
    set_aside_.erase(again, set_aside_.end());
    return true;
}

void LostSets::forgive(std::uint64_t worker, double now_s) {
    for (auto* sets : {&waiting_, &set_aside_})
        for (LostSet& lost : *sets) std::erase(lost.lost_with, worker);
    for (std::size_t i = 0; i < set_aside_.size();) {
        if (set_aside_[i].lost_with.size() >= limits::losses_max) {
            ++i;
            continue;
        }
        LostSet back = std::move(set_aside_[i]);
        set_aside_.erase(set_aside_.begin() + static_cast<std::ptrdiff_t>(i));
        add(std::move(back), now_s);
    }
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

std::uint64_t LostSets::particles_of(const std::vector<LostSet>& sets) {
    return std::accumulate(sets.begin(), sets.end(), std::uint64_t{0},
                           [](std::uint64_t sum, const LostSet& lost) { return sum + lost.range.count; });
}

std::vector<LostSet> LostSets::extract_below(std::uint32_t source) {
    std::vector<LostSet> extracted;
    for (std::vector<LostSet>* sets : {&waiting_, &set_aside_})
        std::erase_if(*sets, [&](const LostSet& set) {
            if (set.range.source >= source) return false;
            extracted.push_back(set);
            return true;
        });
    return extracted;
}

void LostSets::remove(const ParticleRange& range) {
    const std::uint64_t end = range.first + range.count;
    for (std::vector<LostSet>* sets : {&waiting_, &set_aside_}) {
        std::vector<LostSet> left;
        for (const LostSet& lost : *sets) {
            const std::uint64_t lost_end = lost.range.first + lost.range.count;
            const auto keep = [&](std::uint64_t first, std::uint64_t until) {
                if (first >= until) return;
                left.push_back(lost);
                left.back().range = {lost.range.source, first, until - first};
            };
            const bool apart = lost.range.source != range.source || lost_end <= range.first || end <= lost.range.first;
            keep(lost.range.first, apart ? lost_end : range.first);
            if (apart) continue;
            keep(end, lost_end);
        }
        *sets = std::move(left);
    }
}

}  // namespace lumenfarm
