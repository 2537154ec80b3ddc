#pragma once

#include "master/staged_result.h"

#include <cstdint>

namespace lumenfarm {

/// A number that results of the same particles share however they are divided: the fingerprints of results sum, modulo
/// 2^64, to that of one result of all their particles. Each sum is weighted by a hash of its place, each hit counts as
/// its hash (XXH3-64); so two results that differ share it with a chance of about 2^-64, and nobody can aim at that who
/// does not know `key`. Of kept hits those count whose priority is at most `keep_threshold`. REQUIRES: complete, and of
/// one packing.
std::uint64_t result_fingerprint(const StagedResult& result, std::uint64_t keep_threshold, std::uint64_t key);

}  // namespace lumenfarm
