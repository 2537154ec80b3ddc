#pragma once

#include "cli/temporary_folder.h"
#include "common/support/result.h"
#include "master/master_server.h"
#include "worker/worker_client.h"

#include <cstdint>
#include <future>
#include <memory>
#include <string>
#include <vector>

namespace lumenfarm {

/// A master and workers in this process that talk over real TCP on loopback, with storage that goes when they go.
class EmbeddedFarm {
public:
    struct Options {
        std::uint32_t workers = 1;
        std::uint32_t threads = 1;             ///< of each worker
        std::string isa;                       ///< Embree ISA; empty: the best of this machine
        std::uint64_t memory_limit_bytes = 0;  ///< of each worker; 0: as WorkerOptions
        bool parts_only = false;               ///< as WorkerOptions
    };
    /// `storage` outlives the farm. Errors: bad_input (ISA), failed (no port, disk, memory).
    static Result<std::unique_ptr<EmbeddedFarm>> start(const Options& options, const TemporaryFolder& storage);
    ~EmbeddedFarm();

    MasterServer& master() { return *master_; }
    /// Errors: failed when no worker is left.
    Result<void> check_workers();

private:
    struct Hand {
        std::unique_ptr<WorkerClient> worker;
        std::shared_future<Result<void>> ended;  ///< what WorkerClient::wait() gave
    };

    EmbeddedFarm() = default;
    Result<void> hire(const WorkerOptions& options);

    std::unique_ptr<MasterServer> master_;
    std::vector<Hand> hands_;
};

}  // namespace lumenfarm
