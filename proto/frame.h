#pragma once

#include "common/support/limits.h"
#include "proto/message_type.h"
#include "proto/wire_error.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// The frame: a header of 32 bytes, parsed by hand, then the payload. Offsets (docs/wire.md), little-endian:
///   0 u32 magic | 4 u16 protocol | 6 u16 type | 8 u32 flags | 12 u32 payload bytes | 16 u32 raw bytes | 20 u64 request
///   id | 28 u32 checksum
/// Raw bytes: of the payload after decompression; equal to payload bytes when not compressed. Checksum: XXH3-64
/// of the payload as it travels, seeded with the XXH3-64 of header bytes 0 to 27, both halves xor-ed.
namespace lumenfarm::wire {

inline constexpr std::uint32_t frame_magic = 0x4d52464cu;  ///< "LFRM"
inline constexpr std::uint32_t flag_compressed = 1;        ///< payload is one zstd frame

struct FrameHeader {
    std::uint16_t protocol = protocol_newest;
    MessageType type = MessageType::hello;
    std::uint32_t flags = 0;
    std::uint32_t payload_bytes = 0;
    std::uint32_t raw_bytes = 0;
    std::uint64_t request_id = 0;
    std::uint32_t checksum = 0;
    bool compressed() const { return (flags & flag_compressed) != 0; }
    bool operator==(const FrameHeader&) const = default;
};
using HeaderBytes = std::array<std::byte, limits::frame_header_bytes>;

HeaderBytes encode_header(const FrameHeader& header);

/// What the checksum field has to be; `header` counts without that field, `payload` is as it travels.
std::uint32_t frame_checksum(const HeaderBytes& header, std::span<const std::byte> payload);

/// Refuses what no peer may send: wrong magic, version, type, flags, lengths over the type's cap or that contradict
/// each other. Hello and Goodbye pass with any version, so that two programs without a common one can say so.
Decoded<FrameHeader> decode_header(std::span<const std::byte, limits::frame_header_bytes> bytes);

struct FrameOptions {
    std::uint16_t protocol = protocol_newest;
    bool compress = false;  ///< payloads from limits::compress_bytes_min on, where it makes them smaller
};

/// Starts a frame: room for the header, after which the payload is appended.
std::vector<std::byte> begin_frame();
/// Ends it: compresses if asked, and writes the header. REQUIRES: `frame` from begin_frame(), payload within the type's
/// cap.
void finish_frame(std::vector<std::byte>& frame, MessageType type, std::uint64_t request_id,
                  const FrameOptions& options);

struct Frame {
    FrameHeader header;
    std::vector<std::byte> payload;  ///< decompressed, checksum verified
};

/// Which types a parser lets through, decided before memory is taken for the payload.
struct TypeGate {
    Senders senders = from_anyone;    ///< the roles that the peer may have
    std::optional<MessageType> only;  ///< and this type, or Goodbye, alone

    bool admits(MessageType type) const;
};

/// Cuts a stream into frames. Holds one header and one payload, at most the cap of its type; after a refusal it stays
/// refused.
class FrameParser {
public:
    explicit FrameParser(TypeGate gate) : gate_(gate) {}
    /// For the frames whose header has not been read yet.
    void set_gate(TypeGate gate) { gate_ = gate; }

    /// Takes bytes off the front of `bytes` up to the end of a frame, and returns that frame; or takes all of them and
    /// returns nothing.
    Decoded<std::optional<Frame>> consume(std::span<const std::byte>& bytes);

    /// True between frames: a stream that ends here ends in order.
    bool at_boundary() const { return header_filled_ == 0; }

private:
    Decoded<std::optional<Frame>> refuse(WireError reason);
    std::optional<WireError> take_header(std::span<const std::byte>& bytes);
    Decoded<std::optional<Frame>> finish();

    TypeGate gate_;
    HeaderBytes header_bytes_{};
    std::size_t header_filled_ = 0;
    FrameHeader header_;
    std::vector<std::byte> payload_;
    std::size_t payload_filled_ = 0;
    std::optional<WireError> refused_;
};

}  // namespace lumenfarm::wire
