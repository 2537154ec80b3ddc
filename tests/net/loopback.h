#pragma once

#include "common/net/connection.h"
#include "common/net/listener.h"

#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lumenfarm::test {

namespace asio = boost::asio;
using asio::ip::tcp;

/// Remembers what a connection told its owner.
struct Recorder : net::ConnectionHandler {
    std::vector<wire::Envelope> messages;
    std::vector<net::Closed> closes;
    int lows = 0;

    void on_message(net::Connection&, wire::Envelope envelope) override { messages.push_back(std::move(envelope)); }
    void on_close(net::Connection&, const net::Closed& closed) override { closes.push_back(closed); }
    void on_outbox_low(net::Connection&) override { ++lows; }
    bool closed() const { return !closes.empty(); }
};

/// A listener on 127.0.0.1, a connection at its end, and a bare socket at the other: the peer that may do anything.
struct Loopback {
    asio::io_context io;
    Recorder recorder;
    net::ConnectionLimits bounds;
    wire::TypeGate gate = net::Connection::stranger();
    std::shared_ptr<net::Connection> connection;
    tcp::socket peer{io};
    std::unique_ptr<net::Listener> listener;

    ~Loopback() {
        if (connection) connection->detach();
        listener.reset();
        io.restart();
        io.poll();
    }
    void connect() {
        auto opened = net::Listener::open(io, {"127.0.0.1", 0}, [this](tcp::socket socket) {
            connection = net::Connection::make(std::move(socket), gate, recorder, bounds);
            connection->start();
        });
        ASSERT_TRUE(opened.has_value()) << opened.error().sentence;
        listener = std::move(*opened);
        peer.connect(listener->local());
        run([&] { return connection != nullptr; });
    }
    /// With a session open for the peer as a worker.
    void connect_worker(double heartbeat_seconds = limits::heartbeat_seconds,
                        double dead_seconds = limits::dead_seconds) {
        connect();
        connection->open_session(wire::from_worker, {}, heartbeat_seconds, dead_seconds);
    }
    /// Runs everything until `done`; false when that takes 10 s.
    template <class Done>
    bool run(Done done) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
        io.restart();
        while (!done())
            if (io.run_one_until(deadline) == 0) return false;
        return true;
    }
    /// The reason of the close that comes.
    std::optional<net::CloseReason> closed_with() {
        if (!run([&] { return recorder.closed(); })) return {};
        return recorder.closes.front().reason;
    }
    void peer_sends(const std::vector<std::byte>& bytes) { asio::write(peer, asio::buffer(bytes)); }
    void peer_sends(const wire::Message& message, std::uint64_t request_id = 0) {
        peer_sends(wire::encode(message, request_id));
    }
    /// The next message that the connection sent.
    wire::Envelope peer_receives() {
        std::optional<wire::Frame> frame;
        while (!frame) {
            // Small reads, so that nothing of the next frame is taken.
            std::byte byte{};
            bool arrived = false;
            boost::system::error_code error;
            asio::async_read(peer, asio::buffer(&byte, 1), [&](const boost::system::error_code& e, std::size_t) {
                error = e;
                arrived = true;
            });
            if (!run([&] { return arrived; }) || error) return wire::Envelope(wire::Goodbye());
            std::span<const std::byte> one(&byte, 1);
            auto parsed = peer_parser_.consume(one);
            if (!parsed) return wire::Envelope(wire::Goodbye());
            frame = std::move(*parsed);
        }
        return wire::Envelope(*wire::decode(frame->header.type, frame->payload), frame->header.request_id);
    }

private:
    wire::FrameParser peer_parser_{{}};
};

}  // namespace lumenfarm::test
