#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <ostream>
#include <string_view>
#include <vector>

/// The last things that happened in a simulated farm: to be read when a seed fails.
namespace lumenfarm::testing {

enum class Who : std::uint8_t { farm, network, master, disk, relay, worker, client };

class History {
public:
    static constexpr std::size_t events_max = 4'096;  ///< older ones are forgotten

    /// `what` outlives the history: a literal, or the name of a message. At most four numbers.
    void note(double time_s, Who who, std::uint64_t index, std::string_view what,
              std::initializer_list<std::uint64_t> numbers = {});
    /// One line an event, the oldest first: time in seconds, who, what.
    void print(std::ostream& to) const;

private:
    struct Event {
        double time_s = 0;
        Who who = Who::farm;
        std::uint64_t index = 0;
        std::string_view what;
        std::array<std::uint64_t, 4> numbers{};
        std::size_t numbers_count = 0;
    };

    std::vector<Event> events_;  ///< a ring once it is full
    std::uint64_t noted_ = 0;
};

}  // namespace lumenfarm::testing
