#pragma once

#include "proto/frame.h"
#include "proto/messages_client.h"
#include "proto/messages_file.h"
#include "proto/messages_result.h"
#include "proto/messages_session.h"
#include "proto/messages_work.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

/// Every message, and its way into and out of a frame.
namespace lumenfarm::wire {

using Message = std::variant<Hello, Welcome, Goodbye, Heartbeat, HeartbeatReply, Refusal, Pull, JobInfo, Lease, JobGone,
                             ReturnLeases, Progress, Drain, PartsHeld, ResultHits, ResultMap, ResultKept, ResultFlights,
                             ResultWork, ResultDone, ResultAck, ManifestRequest, Manifest, ChunkRequest, Chunk, Submit,
                             SubmitReply, StatusRequest, StatusReply, WorkersRequest, WorkersReply, ControlRequest,
                             ControlReply, FetchRequest, FetchReply>;
static_assert(std::variant_size_v<Message> == message_rules.size());

MessageType type_of(const Message& message);
std::string_view name_of(const Message& message);

/// A message with the id that ties a reply to its request; 0 where no reply is due.
struct Envelope {
    Message message;
    std::uint64_t request_id = 0;

    Envelope() = default;
    explicit Envelope(Message message_, std::uint64_t request_id_ = 0)
        : message(std::move(message_)), request_id(request_id_) {}
};

/// The whole frame, header included. REQUIRES: vectors of the message within their limits.
std::vector<std::byte> encode(const Message& message, std::uint64_t request_id = 0, const FrameOptions& options = {});

/// The payload of a frame that FrameParser accepted. Refuses with an archive reason; a message that comes out is
/// valid() in all that can be said of it without knowing the job.
Decoded<Message> decode(MessageType type, std::span<const std::byte> payload);

}  // namespace lumenfarm::wire
