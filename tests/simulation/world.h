#pragma once

#include "tests/simulation/chance.h"
#include "tests/simulation/event_queue.h"
#include "tests/simulation/history.h"
#include "tests/simulation/simulated_network.h"

#include <cstdint>

/// What all processes of a simulated farm live in.
namespace lumenfarm::testing {

struct World {
    explicit World(std::uint64_t seed) : chance(seed) {}
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    double now_s() const { return clock.now_s(); }
    void note(Who who, std::uint64_t index, std::string_view what, std::initializer_list<std::uint64_t> numbers = {}) {
        history.note(clock.now_s(), who, index, what, numbers);
    }

    EventQueue clock;
    Chance chance;
    History history;
    SimulatedNetwork network{clock, chance, history};
};

constexpr HostId host_of_worker(std::size_t index) { return 1 + index; }
constexpr HostId host_of_relay(std::size_t index) { return 500 + index; }
constexpr HostId host_of_client(std::size_t index) { return 1'000 + index; }

}  // namespace lumenfarm::testing
