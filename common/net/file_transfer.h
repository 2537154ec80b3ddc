#pragma once

#include "common/net/blocking_client.h"
#include "common/support/digest.h"
#include "common/support/result.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// Chunked files between the command and the master (messages_file.h).
namespace lumenfarm::net {

/// Takes the bytes of a file in order; an error ends the transfer.
using FileSink = std::function<Result<void>(std::span<const std::byte>)>;

/// Fetches a file by its digest; every chunk is checked when it arrives and the whole at the end. Errors: failed (not
/// there, lost connection, bytes that do not match their digest, more than `bytes_max`), or the sink's.
Result<void> fetch_file(BlockingClient& client, const Digest& file, std::uint64_t bytes_max, const FileSink& sink);

/// The same into memory.
Result<std::vector<std::byte>> fetch_file(BlockingClient& client, const Digest& file, std::uint64_t bytes_max);

/// Submits a job, uploading the chunks of the scene that the master lacks, and returns its number. `key`: random, of
/// this job. Errors: bad_input (the master refuses the job), failed.
Result<std::uint64_t> submit_job(BlockingClient& client, std::uint64_t key, const JobSpec& spec,
                                 std::span<const std::byte> scene_bytes);

}  // namespace lumenfarm::net
