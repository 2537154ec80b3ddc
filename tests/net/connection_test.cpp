#include "common/net/connection.h"

#include "tests/net/loopback.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iterator>

namespace lumenfarm::net {
namespace {

namespace asio = boost::asio;
using test::Loopback;
using wire::WireError;

constexpr double short_seconds = 0.05;

template <class M>
const M& only_message(const Loopback& farm) {
    EXPECT_EQ(farm.recorder.messages.size(), 1u);
    return std::get<M>(farm.recorder.messages.at(0).message);
}

TEST(Connection, DeliversMessagesWithTheirRequestId) {
    Loopback farm;
    farm.connect();
    farm.peer_sends(wire::Hello(wire::Role::submitter, "desk", 5), 9);
    ASSERT_TRUE(farm.run([&] { return !farm.recorder.messages.empty(); }));
    EXPECT_EQ(only_message<wire::Hello>(farm).name, "desk");
    EXPECT_EQ(farm.recorder.messages[0].request_id, 9u);
    EXPECT_TRUE(farm.connection->peer_is_loopback());
}

TEST(Connection, SendsInOrder) {
    Loopback farm;
    farm.connect_worker();
    for (std::uint64_t i = 0; i < 50; ++i) EXPECT_TRUE(farm.connection->send(wire::JobGone(i), i));
    for (std::uint64_t i = 0; i < 50; ++i) {
        const auto envelope = farm.peer_receives();
        EXPECT_EQ(std::get<wire::JobGone>(envelope.message).job, i);
        EXPECT_EQ(envelope.request_id, i);
    }
    EXPECT_EQ(farm.connection->outbox_bytes(), 0u);
    EXPECT_EQ(farm.connection->counters().messages_out, 50u);
}

TEST(Connection, FramesMayArriveInAnyPieces) {
    Loopback farm;
    farm.connect_worker();
    auto bytes = wire::encode(wire::Pull(1));
    const auto second = wire::encode(wire::Pull(2));
    bytes.insert(bytes.end(), second.begin(), second.end());
    for (const auto byte : bytes) {
        farm.peer_sends(std::vector{byte});
        farm.io.restart();
        farm.io.poll();
    }
    ASSERT_TRUE(farm.run([&] { return farm.recorder.messages.size() == 2; }));
    EXPECT_EQ(std::get<wire::Pull>(farm.recorder.messages[1].message).sets, 2u);
}

TEST(Connection, StrangerWhoSaysNothingIsClosed) {
    Loopback farm;
    farm.bounds.first_message_seconds = short_seconds;
    farm.connect();
    EXPECT_EQ(farm.closed_with(), CloseReason::no_hello);
}

TEST(Connection, StrangerWhoDripsBytesIsClosedAllTheSame) {
    Loopback farm;
    farm.bounds.first_message_seconds = short_seconds;
    farm.connect();
    const auto hello = wire::encode(wire::Hello());
    std::size_t sent = 0;
    const auto drip = [&] {
        if (sent + 1 < hello.size() && !farm.recorder.closed()) farm.peer_sends(std::vector{hello[sent++]});
        return farm.recorder.closed();
    };
    EXPECT_TRUE(farm.run(drip));
    EXPECT_EQ(farm.closed_with(), CloseReason::no_hello);
}

TEST(Connection, StrangerMayOnlySayHello) {
    Loopback farm;
    farm.connect();
    farm.peer_sends(wire::Pull(1));
    EXPECT_EQ(farm.closed_with(), CloseReason::protocol_error);
    EXPECT_EQ(farm.recorder.closes[0].wire, WireError::unexpected_type);
    EXPECT_TRUE(farm.recorder.messages.empty());
}

TEST(Connection, HelloOverFourKibibytesIsRefusedByItsHeaderAlone) {
    Loopback farm;
    farm.connect();
    wire::FrameHeader header;
    header.type = wire::MessageType::hello;
    header.payload_bytes = header.raw_bytes = 4'097;
    const auto bytes = wire::encode_header(header);
    farm.peer_sends(std::vector<std::byte>(bytes.begin(), bytes.end()));
    EXPECT_EQ(farm.closed_with(), CloseReason::protocol_error);
    EXPECT_EQ(farm.recorder.closes[0].wire, WireError::payload_too_large);
}

TEST(Connection, GarbageIsRefusedWithoutAnAnswer) {
    Loopback farm;
    farm.connect();
    const std::string request = "GET / HTTP/1.1\r\nHost: master\r\n\r\n";
    boost::asio::write(farm.peer, boost::asio::buffer(request));
    EXPECT_EQ(farm.closed_with(), CloseReason::protocol_error);
    EXPECT_EQ(farm.recorder.closes[0].wire, WireError::bad_magic);
    EXPECT_EQ(farm.connection->counters().bytes_out, 0u);
}

TEST(Connection, PeerThatBreaksTheProtocolInASessionIsTold) {
    Loopback farm;
    farm.connect_worker();
    auto frame = wire::encode(wire::Pull(1));
    frame.back() ^= std::byte{1};
    farm.peer_sends(frame);
    const auto answer = farm.peer_receives();
    EXPECT_EQ(std::get<wire::Goodbye>(answer.message).reason, wire::GoodbyeReason::protocol_error);
    EXPECT_EQ(std::get<wire::Goodbye>(answer.message).text, "bad_checksum");
    farm.peer.close();
    EXPECT_EQ(farm.closed_with(), CloseReason::protocol_error);
}

TEST(Connection, SecondHelloIsRefused) {
    Loopback farm;
    farm.connect_worker();
    farm.peer_sends(wire::Hello());
    farm.peer_receives();
    farm.peer.close();
    EXPECT_EQ(farm.closed_with(), CloseReason::protocol_error);
    EXPECT_EQ(farm.recorder.closes[0].wire, WireError::unexpected_type);
}

TEST(Connection, EndOfStreamBetweenMessagesIsOrderly) {
    Loopback farm;
    farm.connect_worker();
    farm.peer_sends(wire::Pull(1));
    farm.peer.close();
    EXPECT_EQ(farm.closed_with(), CloseReason::by_peer);
    EXPECT_EQ(farm.recorder.messages.size(), 1u);
}

TEST(Connection, EndOfStreamInsideAMessageIsNot) {
    Loopback farm;
    farm.connect_worker();
    auto frame = wire::encode(wire::Pull(1));
    frame.pop_back();
    farm.peer_sends(frame);
    farm.peer.close();
    EXPECT_EQ(farm.closed_with(), CloseReason::half_frame);
    EXPECT_TRUE(farm.recorder.messages.empty());
}

TEST(Connection, ResetIsANetworkError) {
    Loopback farm;
    farm.connect_worker();
    farm.peer.set_option(boost::asio::socket_base::linger(true, 0));
    farm.peer.close();
    EXPECT_EQ(farm.closed_with(), CloseReason::network_error);
}

TEST(Connection, HalfOpenPeerIsFoundByItsSilence) {
    Loopback farm;
    farm.connect_worker(1.0, 2 * short_seconds);
    EXPECT_EQ(farm.closed_with(), CloseReason::silent);
}

TEST(Connection, SilenceDoesNotCountWhileReadingIsPaused) {
    Loopback farm;
    farm.connect_worker(short_seconds, 2 * short_seconds);
    farm.connection->pause_reading();
    // Heartbeats leave on time, so the fourth one means that the limit has passed twice.
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::holds_alternative<wire::Heartbeat>(farm.peer_receives().message)) << i;
    EXPECT_FALSE(farm.recorder.closed());
    farm.connection->resume_reading();
    EXPECT_EQ(farm.closed_with(), CloseReason::silent);
}

TEST(Connection, HeartbeatsAreAnsweredAndReported) {
    Loopback farm;
    farm.connect_worker();
    farm.peer_sends(wire::Heartbeat(41));
    EXPECT_EQ(std::get<wire::HeartbeatReply>(farm.peer_receives().message).sequence, 41u);
    EXPECT_EQ(only_message<wire::Heartbeat>(farm).sequence, 41u);
}

TEST(Connection, PausedReaderDeliversNothingAndLosesNothing) {
    Loopback farm;
    farm.connect_worker();
    farm.connection->pause_reading();
    for (std::uint32_t i = 0; i < 10; ++i) farm.peer_sends(wire::Pull(i));
    // The pause comes with a read under way; its bytes are kept.
    ASSERT_TRUE(farm.run([&] { return farm.connection->counters().bytes_in > 0; }));
    EXPECT_TRUE(farm.recorder.messages.empty());
    farm.connection->resume_reading();
    ASSERT_TRUE(farm.run([&] { return farm.recorder.messages.size() == 10; }));
    for (std::uint32_t i = 0; i < 10; ++i) EXPECT_EQ(std::get<wire::Pull>(farm.recorder.messages[i].message).sets, i);
}

const wire::Message& large_message() {
    static const wire::Message message = wire::Chunk(Digest(), 0, std::vector<std::byte>(limits::chunk_bytes));
    return message;
}

TEST(Connection, LargeMessagesArriveWholeThroughPauses) {
    Loopback farm;
    farm.connect_worker();
    wire::ResultHits hits({1, 2, 0}, 0, std::vector<HitRecord>(limits::hits_per_message_max), {});
    for (std::uint32_t i = 0; i < hits.records.size(); ++i) hits.records[i].triangle = i;
    constexpr std::size_t count = 5;
    std::vector<std::byte> stream;
    for (std::size_t i = 0; i < count; ++i) std::ranges::copy(wire::encode(hits), std::back_inserter(stream));
    asio::async_write(farm.peer, asio::buffer(stream), [](const boost::system::error_code&, std::size_t) {});
    const auto bytes_in = [&] { return farm.connection->counters().bytes_in; };
    const auto& messages = farm.recorder.messages;
    while (messages.size() < count) {
        // the pause comes with a read under way
        farm.connection->pause_reading();
        const auto bytes_before = bytes_in();
        const auto messages_before = messages.size();
        ASSERT_TRUE(farm.run([&] { return bytes_in() > bytes_before; }));
        EXPECT_EQ(messages.size(), messages_before);
        farm.connection->resume_reading();
        const auto bytes_kept = bytes_in();
        ASSERT_TRUE(farm.run([&] { return messages.size() == count || bytes_in() > bytes_kept; }));
    }
    for (const auto& envelope : messages) EXPECT_EQ(std::get<wire::ResultHits>(envelope.message), hits);
}

TEST(Connection, OutboxIsBounded) {
    Loopback farm;
    farm.connect_worker();
    std::size_t sent = 0;
    // Nobody reads at the other end.
    while (farm.connection->send(large_message())) {
        ++sent;
        EXPECT_LE(farm.connection->outbox_bytes(), limits::outbox_bytes_max);
        ASSERT_LT(sent, 1'000u);
    }
    EXPECT_EQ(farm.closed_with(), CloseReason::outbox_full);
    EXPECT_GE(sent, limits::outbox_bytes_max / limits::frame_payload_bytes_max);
    EXPECT_FALSE(farm.connection->send(wire::Drain()));
}

TEST(Connection, OwnerIsToldWhenTheOutboxHasEmptied) {
    Loopback farm;
    farm.bounds.outbox_bytes_high = 1'000;
    farm.bounds.outbox_bytes_low = 100;
    farm.connect_worker();
    for (std::uint64_t i = 0; i < 100; ++i) farm.connection->send(wire::JobGone(i));
    EXPECT_TRUE(farm.connection->congested());
    EXPECT_TRUE(farm.run([&] { return farm.recorder.lows == 1; }));
    EXPECT_FALSE(farm.connection->congested());
}

TEST(Connection, PeerThatTakesNoBytesIsClosed) {
    Loopback farm;
    farm.connect_worker(10.0, 4 * short_seconds);
    for (int i = 0; i < 8; ++i) farm.connection->send(large_message());
    bool stop = false;
    const auto talk = [&] {
        if (!stop && !farm.recorder.closed()) {
            // Alive, but it does not read.
            boost::system::error_code error;
            const auto beat = wire::encode(wire::HeartbeatReply(1));
            boost::asio::write(farm.peer, boost::asio::buffer(beat), error);
            stop = error.failed();
        }
        return farm.recorder.closed();
    };
    EXPECT_TRUE(farm.run(talk));
    EXPECT_EQ(farm.closed_with(), CloseReason::write_stalled);
}

TEST(Connection, GoodbyeArrivesBeforeTheClose) {
    Loopback farm;
    farm.connect_worker();
    // Unread bytes at the moment of the close would turn it into a reset.
    for (int i = 0; i < 100; ++i) farm.peer_sends(wire::Pull(1));
    farm.connection->finish(wire::Goodbye(wire::GoodbyeReason::shutting_down, "restart"));
    const auto goodbye = std::get<wire::Goodbye>(farm.peer_receives().message);
    EXPECT_EQ(goodbye.reason, wire::GoodbyeReason::shutting_down);
    EXPECT_EQ(goodbye.text, "restart");
    farm.peer.close();
    EXPECT_EQ(farm.closed_with(), CloseReason::by_us);
    EXPECT_TRUE(farm.recorder.messages.empty());
}

TEST(Connection, GoodbyeDoesNotWaitForEverForThePeer) {
    Loopback farm;
    farm.bounds.goodbye_seconds = short_seconds;
    farm.connect_worker();
    farm.connection->finish(wire::Goodbye());
    EXPECT_EQ(farm.closed_with(), CloseReason::by_us);
}

TEST(Connection, GoodbyeOfThePeerIsTheReason) {
    Loopback farm;
    farm.connect_worker();
    farm.peer_sends(wire::Goodbye(wire::GoodbyeReason::done, "that was all"));
    EXPECT_EQ(farm.closed_with(), CloseReason::goodbye);
    EXPECT_EQ(farm.recorder.closes[0].goodbye->text, "that was all");
}

TEST(Connection, PeerOfAnotherVersionIsTold) {
    Loopback farm;
    farm.connect_worker();
    farm.peer_sends(wire::encode(wire::Pull(1), 0, {wire::protocol_newest + 1, false}));
    const auto goodbye = std::get<wire::Goodbye>(farm.peer_receives().message);
    EXPECT_EQ(goodbye.reason, wire::GoodbyeReason::unsupported_protocol);
}

TEST(Connection, CloseIsReportedOnce) {
    Loopback farm;
    farm.connect_worker();
    farm.connection->close();
    farm.connection->close();
    farm.connection->finish(wire::Goodbye());
    EXPECT_EQ(farm.closed_with(), CloseReason::by_us);
    farm.io.restart();
    farm.io.poll();
    EXPECT_EQ(farm.recorder.closes.size(), 1u);
}

TEST(Connection, DetachedOwnerHearsNothing) {
    Loopback farm;
    farm.connect_worker();
    farm.peer_sends(wire::Pull(1));
    farm.connection->detach();
    farm.io.restart();
    farm.io.poll();
    EXPECT_TRUE(farm.recorder.messages.empty());
    EXPECT_TRUE(farm.recorder.closes.empty());
}

TEST(Connection, CompressedSessionCarriesTheSameMessages) {
    Loopback farm;
    farm.connect();
    farm.connection->open_session(wire::from_worker, {wire::protocol_newest, true}, 5, 15);
    farm.connection->send(large_message());
    const auto chunk = farm.peer_receives();
    EXPECT_TRUE(chunk.message == large_message());
    EXPECT_LT(farm.connection->counters().bytes_out, limits::chunk_bytes / 10);
}

}  // namespace
}  // namespace lumenfarm::net
