#pragma once

#include "master/job.h"
#include "master/staged_result.h"

#include <cstddef>
#include <span>
#include <vector>

/// A result as it lies in a segment (docs/segment_file.md): the frames of its messages, as they came over the wire.
namespace lumenfarm {

/// REQUIRES: the result is complete.
std::vector<std::byte> encode_result(const StagedResult& result);

/// Reads foreign bytes: checks everything that is checked of a result that comes from a worker. Errors: bad_input.
Result<StagedResult> decode_result(std::span<const std::byte> bytes, JobId job, const JobSpec& spec,
                                   const PreparedJob& prepared);

}  // namespace lumenfarm
