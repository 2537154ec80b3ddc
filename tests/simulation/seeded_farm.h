#pragma once

#include "tests/simulation/farm.h"

#include <cstdint>
#include <memory>

namespace lumenfarm::testing {

/// A farm of which everything derives from one seed: jobs, clients, workers, network, disk, storms.
std::unique_ptr<Farm> make_seeded_farm(std::uint64_t seed);

}  // namespace lumenfarm::testing
