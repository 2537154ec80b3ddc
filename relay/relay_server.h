#pragma once

#include "common/service/pulse.h"
#include "common/support/limits.h"
#include "common/support/result.h"
#include "master/serving_options.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

/// The relay as a running thing: RelayCore between a connection to the master above, which it keeps trying to have, and
/// a listener for its workers. lumenfarm-master --upstream is one of these and a signal handler. Logs go to spdlog's
/// default logger.
namespace lumenfarm {

struct RelayOptions : ServingOptions {
    std::string upstream;                          ///< HOST:PORT of the master above
    double drain_seconds = limits::drain_seconds;  ///< from drain() to the end, at most
    std::string name;                              ///< empty: the machine's, and "(relay)"
};

class RelayServer {
public:
    /// Listens, starts its threads and returns; the master above need not be there yet. Errors: bad_input (addresses;
    /// not loopback without allow_plaintext), failed (port busy, storage unwritable or in use).
    static Result<std::unique_ptr<RelayServer>> start(const RelayOptions& options);
    ~RelayServer();  ///< end_now()

    const std::string& address() const;  ///< "ADDRESS:PORT"

    // Any thread may call these.

    /// Lets the workers hand over what they have, hands it up and returns the rest of its leases; wait() returns within
    /// the drain time and limits::goodbye_seconds.
    void drain();
    /// Without waiting for what the workers have.
    void end_now();
    bool ended() const;  ///< wait() would return at once
    /// Until the relay has drained and said goodbye, or the master above refuses it. Errors: failed, with the master's
    /// sentence.
    Result<void> wait();
    std::uint64_t particles_merged() const;  ///< that the master above has acknowledged

    /// The threads that serve. REQUIRES: none is asked after this is gone.
    std::vector<ServingThread> threads();
    /// What the relay does, in one line. Never waits.
    std::string summary() const;

private:
    class Running;
    explicit RelayServer(std::unique_ptr<Running> running);
    std::unique_ptr<Running> running_;
};

}  // namespace lumenfarm
