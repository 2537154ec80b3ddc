#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/// A fuzz target is one file with these two functions. libFuzzer drives the first; as an ordinary test corpus_main.cpp
/// feeds it the seeds and seeded mutations of them.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace lumenfarm::test {

/// Valid inputs of the target, made by our own encoders, so that they never fall behind the format.
std::vector<std::vector<std::byte>> corpus_seeds();

}  // namespace lumenfarm::test
