#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

/// All that is left to chance in a simulated farm, from one seed.
namespace lumenfarm::testing {

class Chance {
public:
    explicit Chance(std::uint64_t seed) : random_(seed) {}

    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    /// Waiting time for something that comes every `mean_s` on the average.
    double exponential(double mean_s) { return std::exponential_distribution<double>(1 / mean_s)(random_); }
    bool happens(double probability) { return uniform(0, 1) < probability; }
    /// From `low` to `high`, both included.
    std::uint64_t number(std::uint64_t low, std::uint64_t high) {
        return std::uniform_int_distribution<std::uint64_t>(low, high)(random_);
    }
    std::mt19937_64& engine() { return random_; }

private:
    std::mt19937_64 random_;
};

}  // namespace lumenfarm::testing
