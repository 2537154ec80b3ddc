#include "proto/frame.h"

#include "common/support/ensure.h"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

namespace lumenfarm::wire {
namespace {

constexpr std::size_t checksum_offset = 28;

template <class T>
void put(HeaderBytes& bytes, std::size_t offset, T value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
}

template <class T>
T get(std::span<const std::byte, limits::frame_header_bytes> bytes, std::size_t offset) {
    T value{};
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

/// Types whose layout is the same in every version.
bool frozen(MessageType type) { return type == MessageType::hello || type == MessageType::goodbye; }

std::optional<WireError> refuse_header(const FrameHeader& header) {
    if (header.protocol == 0) return WireError::unsupported_version;
    const bool spoken = header.protocol >= protocol_oldest && header.protocol <= protocol_newest;
    if (!spoken && !frozen(header.type)) return WireError::unsupported_version;
    const auto* rule = rule_of(header.type);
    if (!rule) return WireError::unknown_type;
    if ((header.flags & ~flag_compressed) != 0) return WireError::unknown_flags;
    if (header.raw_bytes > rule->payload_bytes_max || header.payload_bytes > rule->payload_bytes_max)
        return WireError::payload_too_large;
    const bool agree = header.compressed() ? header.payload_bytes > 0 && header.payload_bytes < header.raw_bytes
                                           : header.payload_bytes == header.raw_bytes;
    if (!agree) return WireError::bad_lengths;
    return {};
}

/// Replaces the payload of `frame` by its compressed form where that is smaller.
bool compress_payload(std::vector<std::byte>& frame) {
    const auto raw = std::span(frame).subspan(limits::frame_header_bytes);
    std::vector<std::byte> packed(limits::frame_header_bytes + ZSTD_compressBound(raw.size()));
    const auto size = ZSTD_compress(packed.data() + limits::frame_header_bytes,
                                    packed.size() - limits::frame_header_bytes, raw.data(), raw.size(), 1);
    if (ZSTD_isError(size) || size >= raw.size()) return false;
    packed.resize(limits::frame_header_bytes + size);
    frame = std::move(packed);
    return true;
}

}  // namespace

HeaderBytes encode_header(const FrameHeader& header) {
    HeaderBytes bytes{};
    put(bytes, 0, frame_magic);
    put(bytes, 4, header.protocol);
    put(bytes, 6, header.type);
    put(bytes, 8, header.flags);
    put(bytes, 12, header.payload_bytes);
    put(bytes, 16, header.raw_bytes);
    put(bytes, 20, header.request_id);
    put(bytes, checksum_offset, header.checksum);
    return bytes;
}

std::uint32_t frame_checksum(const HeaderBytes& header, std::span<const std::byte> payload) {
    const auto seed = XXH3_64bits(header.data(), checksum_offset);
    const auto hash = XXH3_64bits_withSeed(payload.data(), payload.size(), seed);
    return static_cast<std::uint32_t>(hash ^ hash >> 32);
}

Decoded<FrameHeader> decode_header(std::span<const std::byte, limits::frame_header_bytes> bytes) {
    if (get<std::uint32_t>(bytes, 0) != frame_magic) return WireError::bad_magic;
    FrameHeader header;
    header.protocol = get<std::uint16_t>(bytes, 4);
    header.type = get<MessageType>(bytes, 6);
    header.flags = get<std::uint32_t>(bytes, 8);
    header.payload_bytes = get<std::uint32_t>(bytes, 12);
    header.raw_bytes = get<std::uint32_t>(bytes, 16);
    header.request_id = get<std::uint64_t>(bytes, 20);
    header.checksum = get<std::uint32_t>(bytes, checksum_offset);
    if (const auto reason = refuse_header(header)) return *reason;
    return header;
}

std::vector<std::byte> begin_frame() { return std::vector<std::byte>(limits::frame_header_bytes); }

void finish_frame(std::vector<std::byte>& frame, MessageType type, std::uint64_t request_id,
                  const FrameOptions& options) {
    const auto raw_bytes = frame.size() - limits::frame_header_bytes;
    ensure(raw_bytes <= payload_bytes_max(type), "a payload is within its type's cap");
    FrameHeader header;
    header.protocol = options.protocol;
    header.type = type;
    header.request_id = request_id;
    header.raw_bytes = static_cast<std::uint32_t>(raw_bytes);
    if (options.compress && raw_bytes >= limits::compress_bytes_min && compress_payload(frame))
        header.flags |= flag_compressed;
    header.payload_bytes = static_cast<std::uint32_t>(frame.size() - limits::frame_header_bytes);
    const auto unsigned_bytes = encode_header(header);
    header.checksum = frame_checksum(unsigned_bytes, std::span(frame).subspan(limits::frame_header_bytes));
    std::ranges::copy(encode_header(header), frame.begin());
}

bool TypeGate::admits(MessageType type) const {
    const auto* rule = rule_of(type);
    if (!rule || (rule->senders & senders) == 0) return false;
    return !only || type == *only || type == MessageType::goodbye;
}

Decoded<std::optional<Frame>> FrameParser::refuse(WireError reason) {
    refused_ = reason;
    payload_ = {};
    return reason;
}

std::optional<WireError> FrameParser::take_header(std::span<const std::byte>& bytes) {
    const auto take = std::min(bytes.size(), header_bytes_.size() - header_filled_);
    std::copy_n(bytes.begin(), take, header_bytes_.begin() + static_cast<std::ptrdiff_t>(header_filled_));
    header_filled_ += take;
    bytes = bytes.subspan(take);
    if (header_filled_ < header_bytes_.size()) return {};
    const auto header = decode_header(header_bytes_);
    if (!header) return header.error();
    if (!gate_.admits(header->type)) return WireError::unexpected_type;
    header_ = *header;
    payload_.resize(header_.payload_bytes);
    payload_filled_ = 0;
    return {};
}

Decoded<std::optional<Frame>> FrameParser::consume(std::span<const std::byte>& bytes) {
    if (refused_) return *refused_;
    if (header_filled_ < header_bytes_.size()) {
        if (const auto reason = take_header(bytes)) return refuse(*reason);
        if (header_filled_ < header_bytes_.size()) return std::optional<Frame>();
    }
    const auto take = std::min(bytes.size(), payload_.size() - payload_filled_);
    std::copy_n(bytes.begin(), take, payload_.begin() + static_cast<std::ptrdiff_t>(payload_filled_));
    payload_filled_ += take;
    bytes = bytes.subspan(take);
    if (payload_filled_ < payload_.size()) return std::optional<Frame>();
    return finish();
}

Decoded<std::optional<Frame>> FrameParser::finish() {
    if (frame_checksum(header_bytes_, payload_) != header_.checksum) return refuse(WireError::bad_checksum);
    header_filled_ = 0;
    std::optional<Frame> frame(std::in_place);
    frame->header = header_;
    if (!header_.compressed()) {
        frame->payload = std::move(payload_);
        payload_ = {};
        return frame;
    }
    frame->payload.resize(header_.raw_bytes);
    const auto size = ZSTD_decompress(frame->payload.data(), frame->payload.size(), payload_.data(), payload_.size());
    if (ZSTD_isError(size) || size != header_.raw_bytes) return refuse(WireError::bad_compression);
    payload_ = {};
    return frame;
}

}  // namespace lumenfarm::wire
