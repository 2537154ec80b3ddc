#include "common/solution/interval_set.h"

#include <algorithm>
#include <iterator>

namespace lumenfarm {

bool IntervalSet::insert(std::uint64_t begin, std::uint64_t end) {
    if (begin >= end || overlaps(begin, end)) return false;
    size_ += end - begin;
    auto after = end_by_begin_.lower_bound(begin);
    if (after != end_by_begin_.end() && after->first == end) {
        end = after->second;
        after = end_by_begin_.erase(after);
    }
    if (after != end_by_begin_.begin()) {
        const auto before = std::prev(after);
        if (before->second == begin) {
            before->second = end;
            return true;
        }
    }
    end_by_begin_.emplace_hint(after, begin, end);
    return true;
}

bool IntervalSet::erase(std::uint64_t begin, std::uint64_t end) {
    if (begin >= end || !covers(begin, end)) return false;
    size_ -= end - begin;
    const auto around = std::prev(end_by_begin_.upper_bound(begin));
    const std::uint64_t around_end = around->second;
    if (around->first < begin)
        around->second = begin;
    else
        end_by_begin_.erase(around);
    if (end < around_end) end_by_begin_.emplace(end, around_end);
    return true;
}

bool IntervalSet::covers(std::uint64_t begin, std::uint64_t end) const {
    if (begin >= end) return true;
    auto at = end_by_begin_.upper_bound(begin);
    if (at == end_by_begin_.begin()) return false;
    return std::prev(at)->second >= end;
}

bool IntervalSet::overlaps(std::uint64_t begin, std::uint64_t end) const {
    if (begin >= end) return false;
    const auto at = end_by_begin_.lower_bound(end);  // the last interval that begins before `end` stands before it
    return at != end_by_begin_.begin() && std::prev(at)->second > begin;
}

std::vector<IntervalSet::Interval> IntervalSet::gaps(std::uint64_t begin, std::uint64_t end) const {
    std::vector<Interval> gaps;
    auto at = end_by_begin_.upper_bound(begin);
    if (at != end_by_begin_.begin()) begin = std::max(begin, std::prev(at)->second);
    for (; begin < end; begin = at->second, ++at) {
        if (at == end_by_begin_.end() || at->first >= end) {
            gaps.push_back({begin, end});
            break;
        }
        if (begin < at->first) gaps.push_back({begin, at->first});
    }
    return gaps;
}

std::vector<IntervalSet::Interval> IntervalSet::intervals() const {
    std::vector<Interval> all;
    all.reserve(end_by_begin_.size());
    for (const auto& [begin, end] : end_by_begin_) all.push_back({begin, end});
    return all;
}

}  // namespace lumenfarm
