#pragma once

#include <cstdint>
#include <map>
#include <vector>

/// Disjoint half-open intervals of particle indices, merged where they touch.
namespace lumenfarm {

class IntervalSet {
public:
    struct Interval {
        std::uint64_t begin, end;
        bool operator==(const Interval&) const = default;
    };
    /// False, and nothing changes, when [begin, end) is empty or overlaps what is there.
    bool insert(std::uint64_t begin, std::uint64_t end);
    /// False, and nothing changes, when [begin, end) is empty or not all of it is there.
    bool erase(std::uint64_t begin, std::uint64_t end);
    /// True when all of [begin, end) is there.
    bool covers(std::uint64_t begin, std::uint64_t end) const;
    bool overlaps(std::uint64_t begin, std::uint64_t end) const;
    /// What of [begin, end) is not there, in order.
    std::vector<Interval> gaps(std::uint64_t begin, std::uint64_t end) const;
    std::uint64_t size() const { return size_; }
    std::vector<Interval> intervals() const;
    bool operator==(const IntervalSet&) const = default;

private:
    std::map<std::uint64_t, std::uint64_t> end_by_begin_;
    std::uint64_t size_ = 0;
};

}  // namespace lumenfarm
