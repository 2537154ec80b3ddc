#include "common/solution/solution_file.h"

#include "common/scene/scene_file.h"
#include "common/support/ensure.h"
#include "tests/fuzz/fuzzer.h"
#include "tests/scene/sample_scene.h"

using namespace lumenfarm;

/// Solutions from strangers, read beside their scene.
namespace {

const Scene& scene() {
    static const Scene the_scene = test::sample_scene();
    return the_scene;
}

const Digest& scene_name() {
    static const Digest name = scene_digest(encode_scene(scene()));
    return name;
}

Solution empty_solution() {
    Solution solution;
    solution.scene = scene_name();
    solution.spec.texel_m = 0.5;
    solution.committed.resize(scene().lights.size());
    const auto layout = *TexelLayout::make(scene(), solution.spec.texel_m);
    solution.texels.resize(layout.texel_count());
    solution.surfaces.resize(scene().surfaces.size());
    return solution;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    const std::span input(reinterpret_cast<const std::byte*>(bytes), size);
    const auto solution = decode_solution(input, scene(), scene_name());
    if (!solution) {
        ensure(solution.error().code == ErrorCode::bad_input && !solution.error().sentence.empty(),
               "a refusal says why");
        return 0;
    }
    const auto again = decode_solution(encode_solution(*solution).bytes, scene(), scene_name());
    ensure(again.has_value() && solution_digest(*again) == solution_digest(*solution), "a solution survives a round");
    return 0;
}

std::vector<std::vector<std::byte>> lumenfarm::test::corpus_seeds() {
    auto solution = empty_solution();
    std::vector<std::vector<std::byte>> seeds = {encode_solution(solution).bytes};
    solution.spec.keep_hits = 4;
    solution.kept = {{{1, 2, 3, 4, 5, 6, 7}, 0, 65'536}};
    solution.texels[1] = {65'536, 60'000, 50'000, 40'000, 9'765'625, 1};
    solution.surfaces[0][0][0] = {65'536, 50'000, 1};
    solution.committed[0].insert(0, 64);
    solution.balance.particles = 64;
    solution.balance.hits = 1;
    solution.balance.emitted = solution.balance.emitted_by_batch[0] = solution.balance.escaped = 64 * 65'536;
    seeds.push_back(encode_solution(solution).bytes);
    return seeds;
}
