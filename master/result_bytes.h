#pragma once

#include "master/job.h"
#include "master/staged_result.h"

#include <cstddef>
#include <functional>
#include <span>

/// A result as it lies in a segment (docs/segment_file.md): the frames of its messages, as they came over the wire.
namespace lumenfarm {

/// Hands the bytes over frame by frame, so that no result is in memory twice. Errors: that of `take`, which ends it.
/// REQUIRES: the result is complete.
Result<void> encode_result(const StagedResult& result,
                           const std::function<Result<void>(std::span<const std::byte> frame)>& take);

/// Reads foreign bytes: checks everything that is checked of a result that comes from a worker. Errors: bad_input.
Result<StagedResult> decode_result(std::span<const std::byte> bytes, JobId job, const JobSpec& spec,
                                   const PreparedJob& prepared);

}  // namespace lumenfarm
