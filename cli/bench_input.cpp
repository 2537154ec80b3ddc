#include "cli/bench_input.h"

#include "cli/bench/bench_scene.h"
#include "cli/options.h"
#include "common/scene/scene_file.h"

#include <string>
#include <utility>

namespace lumenfarm {

namespace {

constexpr std::uint64_t generated_min = 100;
constexpr std::uint64_t generated_max = 100'000'000;

}  // namespace

void declare_bench_input(CLI::App& app, BenchInput& input) {
    declare_scene_options(app, input.scene);
    app.get_option("SCENE")->required(false);
    count_option(app, "--generate", input.generate, "Instead of SCENE: hills in a room, of so many triangles")
        ->type_name("TRIANGLES")
        ->default_str("");
}

void isa_option(CLI::App& app, std::string& isa) {
    choice_option<std::string>(app, "--isa", isa,
                               {{"auto", ""}, {"sse4.2", "sse4.2"}, {"avx2", "avx2"}, {"avx512", "avx512"}},
                               "Instruction set of the ray queries");
}

Result<CompiledScene> read_bench_scene(const CLI::App& app, const BenchInput& input, Console& console) {
    const bool generated = !app.get_option("--generate")->empty();
    if (generated == !input.scene.file.empty())
        return bad_input("bench " + app.get_name() + " needs either a SCENE or --generate TRIANGLES");
    if (!generated) return read_scene(input.scene, console);
    if (input.generate < generated_min || input.generate > generated_max)
        return bad_input("generate is " + std::to_string(input.generate) + "; it must be from " +
                         std::to_string(generated_min) + " to " + std::to_string(generated_max) + " triangles");
    CompiledScene compiled;
    compiled.scene = make_bench_scene(input.generate);
    compiled.bytes = encode_scene(compiled.scene);
    return compiled;
}

}  // namespace lumenfarm
