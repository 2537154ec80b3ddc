#pragma once

#include "common/support/result.h"

#include <cstdint>
#include <string>

namespace lumenfarm {

/// A hash over the hits of a small built-in trace (diffuse, mirror and glass, both rules of absorption): two programs
/// with the same fingerprint give the same bits. `isa` as in TracerScene::make. Errors: failed (Embree).
Result<std::uint64_t> transport_fingerprint(const std::string& isa = {});

/// That of paced workers (worker/paced), whose results are for measurements only: no farm takes them by mistake.
constexpr std::uint64_t paced_fingerprint(std::uint64_t fingerprint) { return ~fingerprint; }
/// What the workers of a farm must have. Errors: as transport_fingerprint().
Result<std::uint64_t> farm_fingerprint(const std::string& isa, bool paced_workers);

}  // namespace lumenfarm
