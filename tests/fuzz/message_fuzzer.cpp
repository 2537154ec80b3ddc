#include "proto/messages.h"

#include "common/support/ensure.h"
#include "tests/fuzz/fuzzer.h"
#include "tests/proto/sample_messages.h"

#include <algorithm>

using namespace lumenfarm;

/// The payload of one message: its first byte chooses the type, or the build does (LUMENFARM_FUZZ_RULE, the number of
/// the rule), one target a message.
namespace {

#ifdef LUMENFARM_FUZZ_RULE
constexpr std::size_t prefix = 0;
#else
constexpr std::size_t prefix = 1;
#endif

wire::MessageType chosen([[maybe_unused]] std::uint8_t first) {
#ifdef LUMENFARM_FUZZ_RULE
    return wire::message_rules.at(LUMENFARM_FUZZ_RULE).type;
#else
    return wire::message_rules.at(first % wire::message_rules.size()).type;
#endif
}

std::size_t rule_number(wire::MessageType type) {
    return static_cast<std::size_t>(wire::rule_of(type) - wire::message_rules.data());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    if (size < prefix) return 0;
    const auto type = chosen(size > 0 ? *bytes : 0);
    const std::span payload(reinterpret_cast<const std::byte*>(bytes) + prefix, size - prefix);
    const auto message = wire::decode(type, payload);
    if (!message) return 0;
    ensure(wire::type_of(*message) == type, "a message has the type of its frame");
    const auto frame = wire::encode(*message);
    ensure(std::ranges::equal(std::span(frame).subspan(limits::frame_header_bytes), payload),
           "what is accepted is written the same");
    return 0;
}

std::vector<std::vector<std::byte>> lumenfarm::test::corpus_seeds() {
    std::vector<std::vector<std::byte>> seeds;
    for (const auto& message : sample_messages()) {
        const auto number = rule_number(wire::type_of(message));
        if (prefix == 0 && wire::type_of(message) != chosen(0)) continue;
        const auto frame = wire::encode(message);
        seeds.emplace_back(prefix, static_cast<std::byte>(number));
        seeds.back().insert(seeds.back().end(), frame.begin() + limits::frame_header_bytes, frame.end());
    }
    return seeds;
}
