#pragma once

#include "common/support/result.h"

#include <cstdint>
#include <string>

namespace lumenfarm {

/// A hash over the hits of a small built-in trace (diffuse, mirror and glass, both rules of absorption): two programs
/// with the same fingerprint give the same bits. `isa` as in TracerScene::make. Errors: failed (Embree).
Result<std::uint64_t> transport_fingerprint(const std::string& isa = {});

}  // namespace lumenfarm
