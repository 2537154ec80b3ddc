#include "proto/frame.h"

#include "common/support/ensure.h"
#include "proto/messages.h"
#include "tests/fuzz/fuzzer.h"
#include "tests/proto/sample_messages.h"

#include <algorithm>
#include <cstring>

using namespace lumenfarm;

namespace {

constexpr std::byte sealed_mark{1};  ///< first byte of inputs whose first frame gets its checksum made right

/// Otherwise nearly every mutation would end at the checksum and never reach decompression.
void seal(std::vector<std::byte>& frame) {
    wire::HeaderBytes header;
    if (frame.size() < header.size()) return;
    std::copy_n(frame.begin(), header.size(), header.begin());
    const auto checksum = wire::frame_checksum(header, std::span(frame).subspan(header.size()));
    std::memcpy(frame.data() + 28, &checksum, sizeof checksum);
}

void take(const wire::Frame& frame) {
    ensure(frame.payload.size() == frame.header.raw_bytes, "a frame has the length that it states");
    ensure(frame.payload.size() <= wire::payload_bytes_max(frame.header.type), "a frame keeps its cap");
    (void)wire::decode(frame.header.type, frame.payload);
}

/// Feeds the stream in pieces of `step` bytes; returns how many frames came out.
std::size_t parse(std::span<const std::byte> stream, std::size_t step) {
    wire::FrameParser parser({});
    std::size_t frames = 0;
    while (!stream.empty()) {
        auto piece = stream.first(std::min(step, stream.size()));
        stream = stream.subspan(piece.size());
        while (!piece.empty()) {
            const auto frame = parser.consume(piece);
            if (!frame) return frames;
            if (!*frame) continue;
            take(**frame);
            ++frames;
        }
    }
    return frames;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    if (size == 0) return 0;
    const auto* begin = reinterpret_cast<const std::byte*>(bytes);
    std::vector<std::byte> stream(begin + 1, begin + size);
    if (*begin == sealed_mark) seal(stream);
    ensure(parse(stream, stream.size() + 1) == parse(stream, 7), "frames do not depend on how they arrive");
    return 0;
}

std::vector<std::vector<std::byte>> lumenfarm::test::corpus_seeds() {
    std::vector<std::vector<std::byte>> seeds;
    const auto add = [&](const std::vector<std::byte>& stream) {
        for (const auto mark : {std::byte{0}, sealed_mark}) {
            seeds.push_back({mark});
            seeds.back().insert(seeds.back().end(), stream.begin(), stream.end());
        }
    };
    for (const auto& message : sample_messages()) add(wire::encode(message, 5));
    const wire::Chunk chunk(Digest(), 0, std::vector<std::byte>(5'000, std::byte{3}));
    add(wire::encode(chunk, 1, {wire::protocol_newest, true}));
    auto two = wire::encode(wire::Pull(1));
    const auto second = wire::encode(wire::Drain());
    two.insert(two.end(), second.begin(), second.end());
    add(two);
    return seeds;
}
