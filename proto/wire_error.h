#pragma once

#include <boost/system/result.hpp>

#include <cstdint>
#include <string_view>

/// Why foreign bytes were refused. Every reason is counted and tested.
namespace lumenfarm::wire {

enum class WireError : std::uint8_t {
    // frame
    bad_magic,            ///< not our protocol
    unsupported_version,  ///< of the frame's protocol
    unknown_type,
    unexpected_type,  ///< known, but not from this peer or not in this state
    unknown_flags,
    payload_too_large,  ///< over the type's cap, before or after decompression
    bad_lengths,        ///< payload and raw length contradict each other
    bad_checksum,
    bad_compression,
    // archive
    truncated,  ///< a field or a block is longer than what is left
    too_many,   ///< a count or a text is over its limit
    too_deep,
    out_of_memory,  ///< over limits::message_memory_bytes_max
    bad_value,      ///< not a bool, not an enumerator, not finite, or outside what the message states
    trailing_bytes,
};
constexpr WireError enum_last(WireError) { return WireError::trailing_bytes; }

/// The enumerator's name, for logs and counters.
std::string_view name_of(WireError error);

/// A value, or the reason for the refusal.
template <class T>
using Decoded = boost::system::result<T, WireError>;

/// Called when value() is asked of a refused result: a broken assumption, so it aborts.
[[noreturn]] void throw_exception_from_error(const WireError& error, const boost::source_location& where);

}  // namespace lumenfarm::wire
