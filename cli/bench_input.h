#pragma once

#include "cli/console.h"
#include "cli/scene_input.h"
#include "common/support/result.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>

namespace lumenfarm {

/// What a benchmark runs on: SCENE, or --generate TRIANGLES.
struct BenchInput {
    SceneOptions scene;
    std::uint64_t generate = 0;
};
void declare_bench_input(CLI::App& app, BenchInput& input);

void isa_option(CLI::App& app, std::string& isa);

/// Errors: as read_scene(); bad_input (neither or both, impossible number).
Result<CompiledScene> read_bench_scene(const CLI::App& app, const BenchInput& input, Console& console);

}  // namespace lumenfarm
