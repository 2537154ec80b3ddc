#include "common/transport/scene_plan.h"

#include "common/support/ensure.h"
#include "tests/fuzz/fuzzer.h"
#include "tests/scenes/planned_scene.h"

#include <algorithm>

using namespace lumenfarm;

/// Plans of scenes, and parts of a scene whose plan is known, from a master: what is accepted is written the same.
namespace {

const testing::PlannedScene& planned() {
    static const testing::PlannedScene the_scene(8);
    return the_scene;
}

template <class T, class Encode>
void check(const Result<T>& read, std::span<const std::byte> input, const Encode& encode) {
    if (read) {
        ensure(std::ranges::equal(encode(*read), input), "what is accepted is written the same");
    } else {
        ensure(read.error().code == ErrorCode::bad_input && !read.error().sentence.empty(), "a refusal says why");
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    const std::span input(reinterpret_cast<const std::byte*>(bytes), size);
    check(decode_plan(input), input, encode_plan);
    check(decode_part(input, planned().plan), input, encode_part);
    return 0;
}

std::vector<std::vector<std::byte>> lumenfarm::test::corpus_seeds() {
    ScenePlan without_texels = planned().plan;
    without_texels.texel_rows.clear();
    return {encode_plan(planned().plan), encode_plan(without_texels), planned().part_bytes.front(),
            planned().part_bytes.back()};
}
