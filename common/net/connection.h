#pragma once

#include "common/net/close_reason.h"
#include "proto/messages.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// One TCP connection that carries frames: one reader, one writer, one bounded outbox, one watchdog. Everything runs on
/// the thread of its io_context; the reader never waits for the writer.
namespace lumenfarm::net {

class Connection;

/// Whoever owns connections. Calls come from the io_context, never from within a call into the Connection.
class ConnectionHandler {
public:
    virtual ~ConnectionHandler() = default;
    /// A whole, checked message. Heartbeats come here too, as signs of life; they have been answered already.
    virtual void on_message(Connection& connection, wire::Envelope envelope) = 0;
    /// The last call for this connection, exactly once.
    virtual void on_close(Connection& connection, const Closed& closed) = 0;
    /// The outbox fell under limits::outbox_bytes_low after it had been above limits::outbox_bytes_high.
    virtual void on_outbox_low(Connection&) {}
};

/// Times and bounds of a connection; tests make them small.
struct ConnectionLimits {
    double first_message_seconds = limits::hello_seconds;
    double dead_seconds = limits::dead_seconds;
    double goodbye_seconds = limits::goodbye_seconds;
    std::size_t outbox_bytes_max = limits::outbox_bytes_max;
    std::size_t outbox_bytes_high = limits::outbox_bytes_high;
    std::size_t outbox_bytes_low = limits::outbox_bytes_low;
};

/// Bytes and frames that went through.
struct ConnectionCounters {
    std::uint64_t bytes_in = 0, bytes_out = 0;
    std::uint64_t messages_in = 0, messages_out = 0;
};

class Connection : public std::enable_shared_from_this<Connection> {
public:
    using Socket = boost::asio::ip::tcp::socket;

    /// `gate`: what may come first, e.g. {from_client, hello}. `handler` outlives the connection or detach() is called.
    /// Nothing happens before start().
    static std::shared_ptr<Connection> make(Socket socket, wire::TypeGate gate, ConnectionHandler& handler,
                                            const ConnectionLimits& bounds = {});
    /// What an acceptor takes from a stranger: a Hello and nothing else.
    static wire::TypeGate stranger() { return {wire::from_client, wire::MessageType::hello}; }
    /// What a connecting side takes before it is welcome.
    static wire::TypeGate greeted() { return {wire::from_master, wire::MessageType::welcome}; }

    void start();

    /// Queues a message. False, and the connection closes with outbox_full, when the outbox would grow over its limit;
    /// false when it is closing already. REQUIRES: the message's vectors are within their limits.
    bool send(const wire::Message& message, std::uint64_t request_id = 0);

    /// To be called when Hello or Welcome was accepted: other messages of `senders` may come from now on, a Heartbeat
    /// leaves every `heartbeat_seconds`, and silence of `dead_seconds` closes.
    void open_session(wire::Senders senders, const wire::FrameOptions& options, double heartbeat_seconds,
                      double dead_seconds);

    /// Says Goodbye, closes when it has left, or after goodbye_seconds. What arrives meanwhile is dropped.
    void finish(const wire::Goodbye& goodbye);
    /// Closes now. on_close follows with this reason.
    void close(Closed closed);
    void close() { close({CloseReason::by_us, {}, {}, "closed"}); }
    /// No more calls to the handler, and closes.
    void detach();

    /// Stops taking messages until resume_reading(); TCP then slows the peer down. Silence does not count meanwhile.
    void pause_reading();
    void resume_reading();

    bool open() const { return state_ == State::open; }
    /// True between rising above outbox_bytes_high and falling under outbox_bytes_low: send only what is short.
    bool congested() const { return congested_; }
    std::size_t outbox_bytes() const { return outbox_bytes_; }
    const ConnectionCounters& counters() const { return counters_; }
    const std::string& peer() const { return peer_; }  ///< "address:port"
    bool peer_is_loopback() const { return peer_is_loopback_; }

private:
    using Clock = std::chrono::steady_clock;
    using ErrorCode = boost::system::error_code;
    enum class State : std::uint8_t { fresh, open, finishing, closed };

    Connection(Socket socket, wire::TypeGate gate, ConnectionHandler& handler, const ConnectionLimits& bounds);

    void set_options();
    void read();
    void on_read(const ErrorCode& error, std::size_t size);
    void take_bytes();
    void take_frame(wire::Frame frame);
    void deliver(wire::Message message, std::uint64_t request_id);
    void refuse(wire::WireError reason);

    void push(std::vector<std::byte> frame);
    void write();
    void on_write(const ErrorCode& error, std::size_t size);
    void stop_writing(const ErrorCode& error);
    void drop_written(std::size_t size);

    void end_with(const wire::Goodbye& goodbye, Closed closed);

    void watch();
    void on_watch();
    std::optional<Closed> overdue(Clock::time_point now) const;
    Clock::time_point next_look(Clock::time_point now) const;

    Socket socket_;
    boost::asio::steady_timer watchdog_;
    ConnectionHandler* handler_;
    ConnectionLimits bounds_;
    wire::FrameParser parser_;
    wire::FrameOptions options_;
    std::string peer_;
    bool peer_is_loopback_ = false;
    State state_ = State::fresh;
    Closed ending_;  ///< finishing: what on_close will be told

    std::vector<std::byte> buffer_;
    std::span<const std::byte> unread_;  ///< of buffer_
    bool reading_ = false;
    bool paused_ = false;

    std::deque<std::vector<std::byte>> outbox_;
    std::size_t outbox_bytes_ = 0;
    std::size_t front_written_ = 0;  ///< bytes of outbox_.front() that have left
    bool writing_ = false;
    bool congested_ = false;

    bool greeted_ = false;          ///< the first message has come
    double heartbeat_seconds_ = 0;  ///< 0: no session yet
    std::uint64_t heartbeat_sequence_ = 0;
    Clock::time_point started_, heard_, progressed_, beat_, finishing_since_;
    ConnectionCounters counters_;
};

}  // namespace lumenfarm::net
