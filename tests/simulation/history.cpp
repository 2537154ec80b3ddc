#include "tests/simulation/history.h"

#include <algorithm>
#include <iomanip>

namespace lumenfarm::testing {

namespace {

std::string_view name_of(Who who) {
    switch (who) {
        case Who::farm: return "farm";
        case Who::network: return "connection";
        case Who::master: return "master";
        case Who::disk: return "disk";
        case Who::relay: return "relay";
        case Who::worker: return "worker";
        case Who::client: return "client";
    }
    return "";
}

}  // namespace

void History::note(double time_s, Who who, std::uint64_t index, std::string_view what,
                   std::initializer_list<std::uint64_t> numbers) {
    Event event{time_s, who, index, what, {}, std::min<std::size_t>(numbers.size(), 4)};
    std::copy_n(numbers.begin(), event.numbers_count, event.numbers.begin());
    if (events_.size() < events_max) {
        events_.push_back(event);
    } else {
        events_[noted_ % events_max] = event;
    }
    ++noted_;
}

void History::print(std::ostream& to) const {
    if (noted_ > events_max) to << noted_ - events_max << " earlier events are forgotten\n";
    for (std::uint64_t i = noted_ - events_.size(); i < noted_; ++i) {
        const Event& event = events_[i % events_max];
        to << std::fixed << std::setprecision(3) << std::setw(10) << event.time_s << "  " << name_of(event.who) << ' '
           << event.index << ": " << event.what;
        for (std::size_t n = 0; n < event.numbers_count; ++n) to << ' ' << event.numbers[n];
        to << '\n';
    }
}

}  // namespace lumenfarm::testing
