#pragma once

#include "common/solution/run_folder.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

/// A part of a solution's particles traced again, and compared with what the solution says of them.
namespace lumenfarm {

/// What the batches of particles (batch_of()) gave when they were traced again. Of a part of the batches a solution
/// says: hits, energy and luminous energy of each side of each surface, the energy of the lights, and which hits are
/// kept. Of all of them it says everything.
struct Verification {
    std::vector<std::uint32_t> batches;
    std::uint64_t particles = 0;
    std::uint64_t hits = 0;
    std::vector<std::string> differences;  ///< one sentence each, at most verification_differences_max
    std::uint64_t more_differences = 0;
};
inline constexpr std::size_t verification_differences_max = 20;

/// REQUIRES: the tracer is of the run's scene; `batches` ascend, under limits::batches; threads > 0. `progress`: called
/// by one thread at a time with the fraction that is done.
Verification verify(const LoadedRun& run, const TracerScene& tracer, std::vector<std::uint32_t> batches,
                    unsigned threads, const std::function<void(double)>& progress);

}  // namespace lumenfarm
