#include "master/farm_counts.h"

#include <string>

namespace lumenfarm {

void FarmCounts::count(const net::Closed& closed) {
    closes.count(closed.reason);
    if (closed.wire) refused_frames.count(*closed.wire);
}

std::vector<wire::ReasonCount> FarmCounts::listed() const {
    std::vector<wire::ReasonCount> all;
    const auto add = [&](std::string_view group) {
        return [&all, group](auto reason, std::uint64_t count) {
            all.emplace_back(std::string(group), std::string(name_of(reason)), count);
        };
    };
    discards.each([&](Discard reason, std::uint64_t count) { add(group_of(reason))(reason, count); });
    closes.each(add("connections_closed"));
    refused_frames.each(add("frames_refused"));
    refused_requests.each(add("requests_refused"));
    return all;
}

}  // namespace lumenfarm
