#pragma once

#include "common/support/limits.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// The kinds of messages, who may send each, and the largest payload of each: the one place for these caps.
namespace lumenfarm::wire {

/// Version N of the protocol. A program speaks N and N - 1 (docs/wire.md).
inline constexpr std::uint16_t protocol_newest = 1;
inline constexpr std::uint16_t protocol_oldest = 1;

enum class MessageType : std::uint16_t {
    // session
    hello = 1,
    welcome = 2,
    goodbye = 3,
    heartbeat = 4,
    heartbeat_reply = 5,
    refusal = 6,
    // work
    pull = 16,
    job_info = 17,
    lease = 18,
    job_gone = 19,
    return_leases = 20,
    progress = 21,
    drain = 22,
    parts_held = 23,
    // results
    result_hits = 32,
    result_map = 33,
    result_kept = 34,
    result_done = 35,
    result_ack = 36,
    result_flights = 37,
    result_work = 38,
    // chunked files: compiled scenes and solutions
    manifest_request = 48,
    manifest = 49,
    chunk_request = 50,
    chunk = 51,
    // submitters
    submit = 64,
    submit_reply = 65,
    status_request = 66,
    status_reply = 67,
    workers_request = 68,
    workers_reply = 69,
    control_request = 70,
    control_reply = 71,
    fetch_request = 72,
    fetch_reply = 73,
};

/// Bits of who may send a message.
using Senders = std::uint8_t;
inline constexpr Senders from_worker = 1;
inline constexpr Senders from_submitter = 2;
inline constexpr Senders from_master = 4;
inline constexpr Senders from_client = from_worker | from_submitter;
inline constexpr Senders from_anyone = from_client | from_master;

struct MessageRule {
    MessageType type;
    Senders senders;
    std::uint32_t payload_bytes_max;  ///< after decompression; the bytes on the wire are never more
    std::string_view name;
};

inline constexpr std::uint32_t small_payload_bytes_max = 8'192;      ///< fixed fields and one or two texts
inline constexpr std::uint32_t list_payload_bytes_max = 640u << 10;  ///< of leases and claims
inline constexpr std::uint32_t bulk_payload_bytes_max = limits::frame_payload_bytes_max;

inline constexpr auto message_rules = std::to_array<MessageRule>({
    {MessageType::hello, from_client, limits::hello_payload_bytes_max, "Hello"},
    {MessageType::welcome, from_master, small_payload_bytes_max, "Welcome"},
    {MessageType::goodbye, from_anyone, small_payload_bytes_max, "Goodbye"},
    {MessageType::heartbeat, from_anyone, small_payload_bytes_max, "Heartbeat"},
    {MessageType::heartbeat_reply, from_anyone, small_payload_bytes_max, "HeartbeatReply"},
    {MessageType::refusal, from_master, small_payload_bytes_max, "Refusal"},
    {MessageType::pull, from_worker, small_payload_bytes_max, "Pull"},
    {MessageType::job_info, from_master, small_payload_bytes_max, "JobInfo"},
    {MessageType::lease, from_master, bulk_payload_bytes_max, "Lease"},
    {MessageType::job_gone, from_master, small_payload_bytes_max, "JobGone"},
    {MessageType::return_leases, from_worker, list_payload_bytes_max, "ReturnLeases"},
    {MessageType::progress, from_worker, list_payload_bytes_max, "Progress"},
    {MessageType::drain, from_master, small_payload_bytes_max, "Drain"},
    {MessageType::parts_held, from_worker, list_payload_bytes_max, "PartsHeld"},
    {MessageType::result_hits, from_worker, bulk_payload_bytes_max, "ResultHits"},
    {MessageType::result_map, from_worker, bulk_payload_bytes_max, "ResultMap"},
    {MessageType::result_kept, from_worker, bulk_payload_bytes_max, "ResultKept"},
    {MessageType::result_flights, from_worker, bulk_payload_bytes_max, "ResultFlights"},
    {MessageType::result_work, from_worker, bulk_payload_bytes_max, "ResultWork"},
    {MessageType::result_done, from_worker, list_payload_bytes_max, "ResultDone"},
    {MessageType::result_ack, from_master, small_payload_bytes_max, "ResultAck"},
    {MessageType::manifest_request, from_client, small_payload_bytes_max, "ManifestRequest"},
    {MessageType::manifest, from_master, bulk_payload_bytes_max, "Manifest"},
    {MessageType::chunk_request, from_client, small_payload_bytes_max, "ChunkRequest"},
    {MessageType::chunk, from_submitter | from_master, bulk_payload_bytes_max, "Chunk"},
    {MessageType::submit, from_submitter, bulk_payload_bytes_max, "Submit"},
    {MessageType::submit_reply, from_master, bulk_payload_bytes_max, "SubmitReply"},
    {MessageType::status_request, from_submitter, small_payload_bytes_max, "StatusRequest"},
    {MessageType::status_reply, from_master, bulk_payload_bytes_max, "StatusReply"},
    {MessageType::workers_request, from_submitter, small_payload_bytes_max, "WorkersRequest"},
    {MessageType::workers_reply, from_master, bulk_payload_bytes_max, "WorkersReply"},
    {MessageType::control_request, from_submitter, small_payload_bytes_max, "ControlRequest"},
    {MessageType::control_reply, from_master, small_payload_bytes_max, "ControlReply"},
    {MessageType::fetch_request, from_submitter, small_payload_bytes_max, "FetchRequest"},
    {MessageType::fetch_reply, from_master, small_payload_bytes_max, "FetchReply"},
});

/// The rule of a type, or null when there is no such type.
constexpr const MessageRule* rule_of(MessageType type) {
    for (const auto& rule : message_rules)
        if (rule.type == type) return &rule;
    return nullptr;
}

constexpr std::size_t payload_bytes_max(MessageType type) {
    for (const auto& rule : message_rules)
        if (rule.type == type) return rule.payload_bytes_max;
    return 0;
}

constexpr bool caps_within_frame() {
    for (const auto& rule : message_rules)
        if (rule.payload_bytes_max > limits::frame_payload_bytes_max) return false;
    return true;
}
static_assert(caps_within_frame());
static_assert(payload_bytes_max(MessageType::hello) == limits::hello_payload_bytes_max);

}  // namespace lumenfarm::wire
