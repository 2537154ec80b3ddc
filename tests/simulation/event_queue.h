#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

/// The fake clock: events in the order of their times, those of one time in the order in which they were asked for.
namespace lumenfarm::testing {

class EventQueue {
public:
    using Run = std::function<void()>;

    double now_s() const { return now_s_; }
    /// A time that has passed is now.
    void at(double time_s, Run run) {
        events_.push_back({std::max(time_s, now_s_), ++made_, std::move(run)});
        std::push_heap(events_.begin(), events_.end(), later);
    }
    void after(double delay_s, Run run) { at(now_s_ + delay_s, std::move(run)); }

    /// Goes on to the next event. REQUIRES: there is one.
    void step() {
        std::pop_heap(events_.begin(), events_.end(), later);
        const Event next = std::move(events_.back());
        events_.pop_back();
        now_s_ = next.time_s;
        next.run();
    }

private:
    struct Event {
        double time_s;
        std::uint64_t number;
        Run run;
    };
    static bool later(const Event& a, const Event& b) {
        return std::pair(a.time_s, a.number) > std::pair(b.time_s, b.number);
    }

    std::vector<Event> events_;
    std::uint64_t made_ = 0;
    double now_s_ = 0;
};

}  // namespace lumenfarm::testing
