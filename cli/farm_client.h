#pragma once

#include "cli/commands.h"
#include "cli/console.h"
#include "common/net/blocking_client.h"
#include "common/support/result.h"

#include <cstdint>
#include <string>

namespace lumenfarm {

/// A session with the master that the options name. Errors: bad_input (address), failed (nobody there: the sentence
/// says how to name another).
Result<net::BlockingClient> connect_to_farm(const FarmOptions& farm);

/// JOB on the command line. Errors: bad_input.
Result<std::uint64_t> parse_job(const std::string& text);

/// Errors: bad_input (no such job), failed.
Result<wire::JobStatus> ask_status(net::BlockingClient& client, std::uint64_t job);

/// Shows a job's progress until it is over. Gives its last status. Errors: failed (the connection), and whatever the
/// job's end means: see outcome().
Result<wire::JobStatus> watch_job(net::BlockingClient& client, std::uint64_t job, Console& console);

/// Nothing for a job that is done; failed for one that failed, interrupted for one that was cancelled.
Result<void> outcome(const wire::JobStatus& job);

}  // namespace lumenfarm
