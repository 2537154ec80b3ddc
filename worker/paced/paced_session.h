#pragma once

#include "common/support/result.h"
#include "worker/paced/paced_results.h"
#include "worker/worker_client.h"

#include <cstdint>
#include <memory>
#include <vector>

/// Workers that reply at the pace of computers of a given speed, many of them in one process: each with a connection,
/// a core, a loop and a cache of its own, over the same stored results.
namespace lumenfarm {

struct PacedOptions {
    WorkerOptions worker;  ///< of each; its number stands behind the name and the cache
    std::uint32_t workers = 1;
    double particles_per_s = 0;  ///< of a slot, > 0
};

/// Errors: as WorkerClient::start().
Result<std::vector<std::unique_ptr<WorkerClient>>> start_paced_workers(
    const PacedOptions& options, const std::shared_ptr<const worker::PacedResults>& results);

}  // namespace lumenfarm
