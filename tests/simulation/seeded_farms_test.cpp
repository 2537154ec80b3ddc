#include "tests/simulation/seeded_farm.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <string>

/// Farms of which all derives from a seed. LUMENFARM_TEST_SEED is the first seed, LUMENFARM_TEST_SEEDS how many.
namespace lumenfarm::testing {
namespace {

constexpr std::uint64_t seeds_of_the_suite = 500;

const Farm* running = nullptr;  ///< for on_abort(), which can't be told
std::uint64_t running_seed = 0;

/// A broken assumption of the cores ends the process: the farm says what led to it first.
void on_abort(int) {
    if (!running) return;
    std::cerr << "seed " << running_seed << " broke an assumption at " << running->now_s() << " s\n";
    running->history().print(std::cerr);
}

std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
    const char* value = std::getenv(name);
    return value ? std::strtoull(value, nullptr, 10) : otherwise;
}

/// Seconds that the farm lived.
double run_seed(std::uint64_t seed) {
    const auto farm = make_seeded_farm(seed);
    running = farm.get();
    running_seed = seed;
    if (!farm->run()) {
        for (const std::string& violation : farm->violations())
            ADD_FAILURE() << "seed " << seed << " at " << farm->now_s() << " s: " << violation;
        farm->history().print(std::cerr);
    }
    running = nullptr;
    return farm->now_s();
}

TEST(SeededFarms, KeepEveryPromiseThroughStorms) {
    const auto before = std::signal(SIGABRT, on_abort);
    const std::uint64_t first = from_environment("LUMENFARM_TEST_SEED", 1);
    const bool one = std::getenv("LUMENFARM_TEST_SEED") && !std::getenv("LUMENFARM_TEST_SEEDS");
    const std::uint64_t count = one ? 1 : from_environment("LUMENFARM_TEST_SEEDS", seeds_of_the_suite);
    double simulated_s = 0;
    std::uint64_t seed = first;
    for (; seed < first + count && !HasFailure(); ++seed) simulated_s += run_seed(seed);
    std::cout << seed - first << " farms from seed " << first << " lived " << simulated_s / 3600 << " hours\n";
    std::signal(SIGABRT, before);
}

TEST(SeededFarms, OneSeedReplaysAFarm) {
    for (const std::uint64_t seed : {3u, 4u, 5u}) {
        std::ostringstream first, second;
        for (std::ostringstream* story : {&first, &second}) {
            const auto farm = make_seeded_farm(seed);
            EXPECT_TRUE(farm->run());
            farm->history().print(*story);
        }
        EXPECT_EQ(first.str(), second.str());
        EXPECT_FALSE(first.str().empty());
    }
}

}  // namespace
}  // namespace lumenfarm::testing
