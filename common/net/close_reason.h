#pragma once

#include "common/support/result.h"
#include "proto/messages_session.h"
#include "proto/wire_error.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Why a connection ended. Every close has exactly one reason.
namespace lumenfarm::net {

enum class CloseReason : std::uint8_t {
    by_us,           ///< close() or finish() was called
    by_peer,         ///< the stream ended between two frames
    goodbye,         ///< the peer said Goodbye
    half_frame,      ///< the stream ended inside a frame
    no_hello,        ///< the first message did not arrive in time
    silent,          ///< nothing arrived for dead_seconds
    write_stalled,   ///< the peer took no byte for dead_seconds
    outbox_full,     ///< the peer reads too slowly for what it asked for
    protocol_error,  ///< the bytes were refused: Closed::wire says why
    network_error,   ///< reset, unreachable, timed out in the kernel
};
constexpr CloseReason enum_last(CloseReason) { return CloseReason::network_error; }

/// The enumerator's name, for logs and counts.
std::string_view name_of(CloseReason reason);

struct Closed {
    CloseReason reason = CloseReason::by_us;
    std::optional<wire::WireError> wire;   ///< protocol_error
    std::optional<wire::Goodbye> goodbye;  ///< goodbye
    std::string sentence;                  ///< for logs and people; names the peer

    /// The reason's name and the sentence, for logs.
    std::string text() const { return std::string(name_of(reason)) + ": " + sentence; }
};

}  // namespace lumenfarm::net
