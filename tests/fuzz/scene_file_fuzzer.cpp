#include "common/scene/scene_file.h"

#include "common/support/ensure.h"
#include "tests/fuzz/fuzzer.h"
#include "tests/scene/sample_scene.h"

#include <algorithm>

using namespace lumenfarm;

/// Compiled scenes from strangers: what is accepted is valid and is written the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    const std::span input(reinterpret_cast<const std::byte*>(bytes), size);
    const auto scene = decode_scene(input);
    if (!scene) {
        ensure(scene.error().code == ErrorCode::bad_input && !scene.error().sentence.empty(), "a refusal says why");
        return 0;
    }
    ensure(validate(*scene).has_value(), "a scene that was read is valid");
    ensure(std::ranges::equal(encode_scene(*scene), input), "what is accepted is written the same");
    return 0;
}

std::vector<std::vector<std::byte>> lumenfarm::test::corpus_seeds() { return {encode_scene(sample_scene())}; }
