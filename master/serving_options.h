#pragma once

#include "common/support/limits.h"

#include <cstdint>
#include <filesystem>
#include <string>

/// What is said to a master and to a relay alike.
namespace lumenfarm {

struct MasterPolicy;

struct ServingOptions {
    std::string listen = "127.0.0.1:7420";  ///< HOST:PORT; port 0 lets the system choose
    std::filesystem::path storage;          ///< of a relay: files of the jobs at hand lie in its folder "relay"
    bool allow_plaintext = false;  ///< REQUIRED for an address beyond loopback: anybody who reaches it may use the farm
    double set_target_seconds = 2;
    double flush_seconds = 2;
    double dead_seconds = limits::dead_seconds;  ///< REQUIRED: within limits::dead_seconds_min and _max
    double reconnect_seconds = limits::reconnect_seconds;
    std::uint32_t results_in_flight = limits::results_in_flight;  ///< REQUIRED: 1 to limits::results_in_flight_max
    bool compress = false;                                        ///< workers compress their results
    std::string isa;             ///< of the trace that gives the fingerprint; empty: the best of this machine
    bool paced_workers = false;  ///< takes paced workers (worker/paced), and no others: for measurements
};

/// `fingerprint`: that workers must have.
MasterPolicy policy_of(const ServingOptions& options, std::uint64_t fingerprint);

}  // namespace lumenfarm
