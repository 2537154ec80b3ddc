#include "master/serving_options.h"

#include "master/master_core.h"

namespace lumenfarm {

MasterPolicy policy_of(const ServingOptions& options, std::uint64_t fingerprint) {
    MasterPolicy policy;
    policy.fingerprint = fingerprint;
    policy.set_target_seconds = options.set_target_seconds;
    policy.flush_seconds = options.flush_seconds;
    policy.dead_seconds = options.dead_seconds;
    policy.reconnect_seconds = options.reconnect_seconds;
    policy.results_in_flight = options.results_in_flight;
    policy.compress = options.compress;
    return policy;
}

}  // namespace lumenfarm
