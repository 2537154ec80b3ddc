#include "proto/frame.h"

#include "proto/messages.h"

#include <gtest/gtest.h>

#include <cstring>

namespace lumenfarm::wire {
namespace {

using Bytes = std::vector<std::byte>;

const Message& chunk_message() {
    static const Message message = Chunk(Digest(), 3, Bytes(20'000, std::byte{5}));
    return message;
}

/// What a parser that lets everything through makes of the bytes.
Decoded<std::optional<Frame>> parse(Bytes bytes, TypeGate gate = {}) {
    FrameParser parser(gate);
    std::span<const std::byte> rest = bytes;
    return parser.consume(rest);
}

template <class T>
void put(Bytes& frame, std::size_t offset, T value) {
    std::memcpy(frame.data() + offset, &value, sizeof value);
}

/// Makes the checksum right again after a field was changed.
void seal(Bytes& frame) {
    HeaderBytes header;
    std::copy_n(frame.begin(), header.size(), header.begin());
    put(frame, 28, frame_checksum(header, std::span(frame).subspan(header.size())));
}

WireError reason_of(const Bytes& bytes, TypeGate gate = {}) {
    const auto frame = parse(bytes, gate);
    EXPECT_TRUE(frame.has_error());
    return frame.has_error() ? frame.error() : WireError{};
}

TEST(Frame, HeaderHasTheDocumentedBytes) {
    FrameHeader header;
    header.protocol = 0x0201;
    header.type = MessageType::chunk;
    header.flags = 1;
    header.payload_bytes = 0x04030201;
    header.raw_bytes = 0x08070605;
    header.request_id = 0x1817161514131211;
    header.checksum = 0x24232221;
    const std::array<unsigned, 32> expected = {'L',  'F',  'R',  'M',  0x01, 0x02, 51,   0,    1,    0,    0,
                                               0,    0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x11, 0x12,
                                               0x13, 0x14, 0x15, 0x16, 0x17, 0x18, 0x21, 0x22, 0x23, 0x24};
    const auto bytes = encode_header(header);
    for (std::size_t i = 0; i < bytes.size(); ++i) EXPECT_EQ(std::to_integer<unsigned>(bytes[i]), expected[i]) << i;
}

TEST(Frame, WholeFrameHasTheseBytes) {
    const auto frame = encode(Heartbeat(1), 2);
    ASSERT_EQ(frame.size(), 40u);
    EXPECT_EQ(std::to_integer<unsigned>(frame[32]), 1u);
    // XXH3 is stable since 0.8.0; another value here means that old programs are not understood any more.
    std::uint32_t checksum = 0;
    std::memcpy(&checksum, frame.data() + 28, 4);
    EXPECT_EQ(checksum, 1'063'898'840u);
}

TEST(Frame, StreamIsCutIntoFramesHoweverItArrives) {
    auto stream = encode(Pull(3), 11);
    const auto second = encode(chunk_message(), 12);
    stream.insert(stream.end(), second.begin(), second.end());
    for (const std::size_t step : {std::size_t{1}, std::size_t{31}, std::size_t{33}, stream.size()}) {
        FrameParser parser({});
        std::vector<std::uint64_t> ids;
        for (std::size_t begin = 0; begin < stream.size(); begin += step) {
            auto rest = std::span<const std::byte>(stream).subspan(begin, std::min(step, stream.size() - begin));
            while (!rest.empty()) {
                auto frame = parser.consume(rest);
                ASSERT_TRUE(frame.has_value());
                if (*frame) ids.push_back((*frame)->header.request_id);
            }
        }
        EXPECT_EQ(ids, (std::vector<std::uint64_t>{11, 12})) << step;
        EXPECT_TRUE(parser.at_boundary());
    }
}

TEST(Frame, MessageWithoutPayloadIsComplete) {
    const auto frame = parse(encode(WorkersRequest()));
    ASSERT_TRUE(frame.has_value() && frame->has_value());
    EXPECT_TRUE((*frame)->payload.empty());
}

TEST(Frame, CompressedPayloadComesBackWhole) {
    const auto plain = encode(chunk_message());
    const auto packed = encode(chunk_message(), 0, {protocol_newest, true});
    EXPECT_LT(packed.size(), plain.size() / 10);
    const auto frame = parse(packed);
    ASSERT_TRUE(frame.has_value() && frame->has_value());
    EXPECT_EQ((*frame)->payload, Bytes(plain.begin() + 32, plain.end()));
}

TEST(Frame, ShortPayloadIsNotCompressed) { EXPECT_EQ(encode(Pull(1), 0, {protocol_newest, true}), encode(Pull(1))); }

TEST(Frame, EveryFlippedBitIsNoticed) {
    const auto good = encode(Refusal(RefusalReason::full, "no room"), 77);
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
        auto bad = good;
        bad[bit / 8] ^= std::byte{1} << (bit % 8);
        const auto frame = parse(bad);
        EXPECT_TRUE(frame.has_error() || !frame->has_value()) << "bit " << bit;
    }
}

TEST(Frame, EachRefusalHasItsReason) {
    const auto good = encode(chunk_message());
    const auto with = [&](std::size_t offset, auto value) {
        auto bytes = good;
        put(bytes, offset, value);
        seal(bytes);
        return reason_of(bytes);
    };
    EXPECT_EQ(with(0, std::uint32_t{0x12345678}), WireError::bad_magic);
    EXPECT_EQ(with(4, std::uint16_t{0}), WireError::unsupported_version);
    EXPECT_EQ(with(4, std::uint16_t(protocol_newest + 1)), WireError::unsupported_version);
    EXPECT_EQ(with(6, std::uint16_t{999}), WireError::unknown_type);
    EXPECT_EQ(with(8, std::uint32_t{2}), WireError::unknown_flags);
    EXPECT_EQ(with(12, std::uint32_t{0xffffffff}), WireError::payload_too_large);
    EXPECT_EQ(with(16, std::uint32_t{0xffffffff}), WireError::payload_too_large);
    EXPECT_EQ(with(16, std::uint32_t{20'001}), WireError::bad_lengths);
    auto damaged = good;
    damaged.back() ^= std::byte{1};
    EXPECT_EQ(reason_of(damaged), WireError::bad_checksum);
}

TEST(Frame, CapOfTheTypeIsCheckedBeforeThePayloadArrives) {
    FrameHeader header;
    header.type = MessageType::hello;
    header.payload_bytes = header.raw_bytes = limits::hello_payload_bytes_max + 1;
    const auto bytes = encode_header(header);
    EXPECT_EQ(reason_of(Bytes(bytes.begin(), bytes.end())), WireError::payload_too_large);
    header.payload_bytes = header.raw_bytes = limits::hello_payload_bytes_max;
    EXPECT_TRUE(decode_header(encode_header(header)).has_value());
}

TEST(Frame, DecompressionNeverExceedsTheStatedLength) {
    auto bomb = encode(chunk_message(), 0, {protocol_newest, true});
    std::uint32_t payload_bytes = 0;
    std::memcpy(&payload_bytes, bomb.data() + 12, 4);
    put(bomb, 16, payload_bytes + 1);
    seal(bomb);
    EXPECT_EQ(reason_of(bomb), WireError::bad_compression);
    put(bomb, 16, std::uint32_t{30'000});
    seal(bomb);
    EXPECT_EQ(reason_of(bomb), WireError::bad_compression);
}

TEST(Frame, CompressedThatIsNotSmallerIsRefused) {
    auto frame = encode(chunk_message());
    put(frame, 8, flag_compressed);
    seal(frame);
    EXPECT_EQ(reason_of(frame), WireError::bad_lengths);
}

TEST(Frame, HelloAndGoodbyePassWithAnyVersion) {
    const auto passes = [](const Message& message, std::uint16_t version) {
        return parse(encode(message, 0, {version, false})).has_value();
    };
    EXPECT_TRUE(passes(Hello(), protocol_newest + 5));
    EXPECT_TRUE(passes(Goodbye(), protocol_newest + 5));
    EXPECT_FALSE(passes(Pull(), protocol_newest + 5));
    EXPECT_FALSE(passes(Hello(), 0));
}

TEST(Frame, GateRefusesOtherSendersAndOtherTypes) {
    EXPECT_EQ(reason_of(encode(Welcome()), {from_worker, {}}), WireError::unexpected_type);
    EXPECT_EQ(reason_of(encode(Submit()), {from_worker, {}}), WireError::unexpected_type);
    EXPECT_TRUE(parse(encode(Submit()), {from_submitter, {}}).has_value());
    const TypeGate stranger{from_client, MessageType::hello};
    EXPECT_EQ(reason_of(encode(Pull()), stranger), WireError::unexpected_type);
    EXPECT_TRUE(parse(encode(Hello()), stranger).has_value());
    EXPECT_TRUE(parse(encode(Goodbye()), stranger).has_value());
}

TEST(Frame, RefusedStreamStaysRefused) {
    FrameParser parser({});
    const Bytes garbage(64, std::byte{0x5a});
    std::span<const std::byte> rest = garbage;
    EXPECT_EQ(parser.consume(rest).error(), WireError::bad_magic);
    const auto good = encode(Drain());
    rest = good;
    EXPECT_EQ(parser.consume(rest).error(), WireError::bad_magic);
}

}  // namespace
}  // namespace lumenfarm::wire
