#include "proto/messages.h"

#include <array>
#include <utility>

namespace lumenfarm::wire {
namespace {

template <class M>
Decoded<Message> decode_as(std::span<const std::byte> payload) {
    M message;
    InputArchive archive(payload);
    archive >> message;
    archive.finish();
    if constexpr (requires { message.valid(); })
        if (!archive.refused() && !message.valid()) archive.refuse(WireError::bad_value);
    if (archive.refused()) return *archive.refused();
    return Message(std::move(message));
}

struct Decoder {
    MessageType type;
    Decoded<Message> (*decode)(std::span<const std::byte>);
};

template <std::size_t... i>
constexpr auto make_decoders(std::index_sequence<i...>) {
    return std::array{
        Decoder{std::variant_alternative_t<i, Message>::type, &decode_as<std::variant_alternative_t<i, Message>>}...};
}
constexpr auto decoders = make_decoders(std::make_index_sequence<std::variant_size_v<Message>>());

constexpr bool one_decoder_a_rule() {
    for (const auto& rule : message_rules) {
        int found = 0;
        for (const auto& decoder : decoders) found += decoder.type == rule.type;
        if (found != 1) return false;
    }
    return true;
}
static_assert(one_decoder_a_rule());

}  // namespace

MessageType type_of(const Message& message) {
    return std::visit([](const auto& each) { return each.type; }, message);
}

std::string_view name_of(const Message& message) { return rule_of(type_of(message))->name; }

std::vector<std::byte> encode(const Message& message, std::uint64_t request_id, const FrameOptions& options) {
    auto frame = begin_frame();
    OutputArchive archive(frame);
    std::visit([&](const auto& each) { archive << each; }, message);
    finish_frame(frame, type_of(message), request_id, options);
    return frame;
}

Decoded<Message> decode(MessageType type, std::span<const std::byte> payload) {
    if (payload.size() > payload_bytes_max(type)) return WireError::payload_too_large;
    for (const auto& decoder : decoders)
        if (decoder.type == type) return decoder.decode(payload);
    return WireError::unknown_type;
}

std::string_view name_of(JobState state) {
    switch (state) {
        case JobState::queued: return "queued";
        case JobState::running: return "running";
        case JobState::paused: return "paused";
        case JobState::done: return "done";
        case JobState::cancelled: return "cancelled";
        case JobState::failed: return "failed";
    }
    return "?";
}

}  // namespace lumenfarm::wire
