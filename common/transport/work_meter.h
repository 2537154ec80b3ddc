#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace lumenfarm {

/// What following particles in a subspace took. 16 bytes, as on the wire.
struct SubspaceWork {
    std::uint32_t subspace = 0;
    std::uint32_t hits = 0;
    std::uint64_t nanoseconds = 0;
    bool operator==(const SubspaceWork&) const = default;
};
static_assert(sizeof(SubspaceWork) == 16);

/// Adds up work by subspace: that between two looks at the clock is what the second one says.
class WorkMeter {
public:
    /// `clock_s`: processor time of the thread that works [s].
    explicit WorkMeter(std::function<double()> clock_s) : clock_s_(std::move(clock_s)) {}

    void begin() { last_s_ = clock_s_(); }
    /// What was done since begin() or the last lap was in this subspace.
    void lap(std::uint32_t subspace, std::uint64_t hits) {
        SubspaceWork& work = by_subspace_[subspace];
        work.subspace = subspace;
        work.hits += static_cast<std::uint32_t>(hits);
        const double now_s = clock_s_();
        work.nanoseconds += static_cast<std::uint64_t>((now_s - last_s_) * 1e9);
        last_s_ = now_s;
    }
    /// By subspace, ascending. Nothing is left.
    std::vector<SubspaceWork> take() {
        std::vector<SubspaceWork> all;
        for (const auto& [subspace, work] : by_subspace_) all.push_back(work);
        by_subspace_.clear();
        return all;
    }

private:
    std::function<double()> clock_s_;
    double last_s_ = 0;
    std::map<std::uint32_t, SubspaceWork> by_subspace_;
};

}  // namespace lumenfarm
