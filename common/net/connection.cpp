#include "common/net/connection.h"

#include "common/net/address.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>

#include <algorithm>
#include <utility>

namespace lumenfarm::net {
namespace {

using wire::GoodbyeReason;
using wire::MessageType;
using wire::WireError;

constexpr std::size_t frames_per_write = 16;

std::chrono::steady_clock::duration seconds(double count) {
    return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(count));
}

void set_tcp_option(int socket, int option, int value) {
    // A kernel without the option leaves the work to the watchdog.
    ::setsockopt(socket, IPPROTO_TCP, option, &value, sizeof value);
}

}  // namespace

std::shared_ptr<Connection> Connection::make(Socket socket, wire::TypeGate gate, ConnectionHandler& handler,
                                             const ConnectionLimits& bounds) {
    return std::shared_ptr<Connection>(new Connection(std::move(socket), gate, handler, bounds));
}

Connection::Connection(Socket socket, wire::TypeGate gate, ConnectionHandler& handler, const ConnectionLimits& bounds)
    : socket_(std::move(socket)),
      watchdog_(socket_.get_executor()),
      handler_(&handler),
      bounds_(bounds),
      parser_(gate),
      buffer_(limits::read_buffer_bytes) {
    ErrorCode error;
    const auto remote = socket_.remote_endpoint(error);
    peer_ = error ? "unknown peer" : text_of(remote);
    peer_is_loopback_ = !error && is_loopback(remote.address());
}

void Connection::set_options() {
    ErrorCode ignored;
    socket_.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
    socket_.set_option(boost::asio::socket_base::keep_alive(true), ignored);
    set_tcp_option(socket_.native_handle(), TCP_KEEPIDLE, static_cast<int>(limits::heartbeat_seconds));
    set_tcp_option(socket_.native_handle(), TCP_USER_TIMEOUT, static_cast<int>(bounds_.dead_seconds * 1000));
}

void Connection::start() {
    ensure(state_ == State::fresh, "a connection is started once");
    state_ = State::open;
    started_ = heard_ = progressed_ = Clock::now();
    set_options();
    read();
    watch();
}

// Reading

void Connection::read() {
    if (reading_ || paused_ || state_ == State::closed || state_ == State::fresh) return;
    reading_ = true;
    socket_.async_read_some(
        boost::asio::buffer(buffer_),
        [self = shared_from_this()](const ErrorCode& error, std::size_t size) { self->on_read(error, size); });
}

void Connection::on_read(const ErrorCode& error, std::size_t size) {
    reading_ = false;
    if (state_ == State::closed) return;
    if (error == boost::asio::error::eof) {
        if (state_ == State::finishing) return close(std::move(ending_));
        const bool whole = parser_.at_boundary();
        return close({whole ? CloseReason::by_peer : CloseReason::half_frame,
                      {},
                      {},
                      peer_ + (whole ? " closed the connection" : " closed the connection inside a message")});
    }
    if (error) return close({CloseReason::network_error, {}, {}, "lost " + peer_ + ": " + error.message()});
    heard_ = Clock::now();
    counters_.bytes_in += size;
    unread_ = std::span(buffer_).first(size);
    take_bytes();
}

void Connection::take_bytes() {
    while (state_ == State::open && !paused_ && !unread_.empty()) {
        auto frame = parser_.consume(unread_);
        if (!frame) return refuse(frame.error());
        if (*frame) take_frame(std::move(**frame));
    }
    if (state_ == State::finishing) unread_ = {};
    read();
}

void Connection::take_frame(wire::Frame frame) {
    const auto type = frame.header.type;
    const bool greeting = type == MessageType::hello || type == MessageType::welcome;
    if (greeting && greeted_) return refuse(WireError::unexpected_type);
    auto message = wire::decode(type, frame.payload);
    if (!message) return refuse(message.error());
    greeted_ = true;
    ++counters_.messages_in;
    deliver(std::move(*message), frame.header.request_id);
}

void Connection::deliver(wire::Message message, std::uint64_t request_id) {
    if (auto* goodbye = std::get_if<wire::Goodbye>(&message)) {
        auto sentence = peer_ + " said goodbye" + (goodbye->text.empty() ? "" : ": " + goodbye->text);
        return close({CloseReason::goodbye, {}, std::move(*goodbye), std::move(sentence)});
    }
    if (const auto* beat = std::get_if<wire::Heartbeat>(&message))
        if (!send(wire::HeartbeatReply(beat->sequence), request_id)) return;
    if (handler_) handler_->on_message(*this, wire::Envelope(std::move(message), request_id));
}

void Connection::refuse(WireError reason) {
    const auto sentence = peer_ + " broke the protocol: " + std::string(name_of(reason));
    Closed closed{CloseReason::protocol_error, reason, {}, sentence};
    // A stranger that does not speak our protocol gets no answer; one of another version is told.
    if (!greeted_ && reason != WireError::unsupported_version) return close(std::move(closed));
    const auto why =
        reason == WireError::unsupported_version ? GoodbyeReason::unsupported_protocol : GoodbyeReason::protocol_error;
    end_with(wire::Goodbye(why, std::string(name_of(reason))), std::move(closed));
    read();
}

void Connection::pause_reading() { paused_ = true; }

void Connection::resume_reading() {
    if (!std::exchange(paused_, false)) return;
    heard_ = Clock::now();
    boost::asio::post(socket_.get_executor(), [self = shared_from_this()] {
        if (!self->reading_) self->take_bytes();
    });
}

// Writing

bool Connection::send(const wire::Message& message, std::uint64_t request_id) {
    if (state_ != State::open) return false;
    auto frame = wire::encode(message, request_id, options_);
    if (outbox_bytes_ + frame.size() > bounds_.outbox_bytes_max) {
        close({CloseReason::outbox_full, {}, {}, peer_ + " reads too slowly"});
        return false;
    }
    push(std::move(frame));
    return true;
}

void Connection::push(std::vector<std::byte> frame) {
    if (outbox_.empty()) progressed_ = Clock::now();
    outbox_bytes_ += frame.size();
    if (outbox_bytes_ > bounds_.outbox_bytes_high) congested_ = true;
    outbox_.push_back(std::move(frame));
    ++counters_.messages_out;
    write();
}

void Connection::write() {
    if (writing_ || outbox_.empty() || state_ == State::closed) return;
    writing_ = true;
    std::vector<boost::asio::const_buffer> buffers;
    for (std::size_t i = 0; i < std::min(outbox_.size(), frames_per_write); ++i)
        buffers.emplace_back(outbox_[i].data(), outbox_[i].size());
    buffers.front() += front_written_;
    socket_.async_write_some(buffers, [self = shared_from_this()](const ErrorCode& error, std::size_t size) {
        self->on_write(error, size);
    });
}

void Connection::on_write(const ErrorCode& error, std::size_t size) {
    writing_ = false;
    if (state_ == State::closed) return;
    if (error && state_ == State::finishing) return close(std::move(ending_));
    if (error) return stop_writing(error);
    progressed_ = Clock::now();
    drop_written(size);
    if (congested_ && outbox_bytes_ < bounds_.outbox_bytes_low) {
        congested_ = false;
        if (handler_ && state_ == State::open) handler_->on_outbox_low(*this);
    }
    if (outbox_.empty() && state_ == State::finishing) {
        // The peer closes when it has read the Goodbye; closing first would reset what is still under way to it.
        ErrorCode ignored;
        socket_.shutdown(Socket::shutdown_send, ignored);
    }
    write();
}

/// The peer closed its end. What it said last (a Goodbye, perhaps) is still to be read, so the reader decides the
/// reason.
void Connection::stop_writing(const ErrorCode& error) {
    outbox_.clear();
    outbox_bytes_ = front_written_ = 0;
    if (paused_) close({CloseReason::network_error, {}, {}, "lost " + peer_ + ": " + error.message()});
}

void Connection::drop_written(std::size_t size) {
    counters_.bytes_out += size;
    outbox_bytes_ -= size;
    front_written_ += size;
    while (!outbox_.empty() && front_written_ >= outbox_.front().size()) {
        front_written_ -= outbox_.front().size();
        outbox_.pop_front();
    }
}

// Sessions and ends

void Connection::open_session(wire::Senders senders, const wire::FrameOptions& options, double heartbeat_seconds,
                              double dead_seconds) {
    parser_.set_gate({senders, {}});
    options_ = options;
    heartbeat_seconds_ = heartbeat_seconds;
    bounds_.dead_seconds = dead_seconds;
    greeted_ = true;
    beat_ = Clock::now();
    if (state_ == State::open) {
        set_options();
        watch();
    }
}

void Connection::finish(const wire::Goodbye& goodbye) {
    end_with(goodbye, {CloseReason::by_us, {}, {}, "said goodbye to " + peer_});
}

void Connection::end_with(const wire::Goodbye& goodbye, Closed closed) {
    if (state_ != State::open) return;
    state_ = State::finishing;
    ending_ = std::move(closed);
    unread_ = {};
    paused_ = false;
    finishing_since_ = Clock::now();
    push(wire::encode(goodbye, 0, options_));
    read();
    watch();
}

void Connection::close(Closed closed) {
    if (state_ == State::closed) return;
    state_ = State::closed;
    watchdog_.cancel();
    ErrorCode ignored;
    socket_.close(ignored);
    outbox_bytes_ = 0;
    boost::asio::post(socket_.get_executor(), [self = shared_from_this(), closed = std::move(closed)] {
        self->outbox_.clear();
        if (auto* handler = std::exchange(self->handler_, nullptr)) handler->on_close(*self, closed);
    });
}

void Connection::detach() {
    handler_ = nullptr;
    close();
}

// Watchdog

void Connection::watch() {
    watchdog_.expires_at(next_look(Clock::now()));
    watchdog_.async_wait([self = shared_from_this()](const ErrorCode& error) {
        if (!error) self->on_watch();
    });
}

void Connection::on_watch() {
    if (state_ == State::closed) return;
    const auto now = Clock::now();
    if (auto closed = overdue(now)) return close(std::move(*closed));
    if (state_ == State::open && heartbeat_seconds_ > 0 && now >= beat_ + seconds(heartbeat_seconds_)) {
        beat_ = now;
        if (!send(wire::Heartbeat(++heartbeat_sequence_))) return;
    }
    watch();
}

std::optional<Closed> Connection::overdue(Clock::time_point now) const {
    if (state_ == State::finishing && now >= finishing_since_ + seconds(bounds_.goodbye_seconds)) return ending_;
    if (state_ != State::open) return {};
    if (!greeted_ && now >= started_ + seconds(bounds_.first_message_seconds))
        return Closed{CloseReason::no_hello, {}, {}, peer_ + " did not introduce itself in time"};
    if (!outbox_.empty() && now >= progressed_ + seconds(bounds_.dead_seconds))
        return Closed{CloseReason::write_stalled, {}, {}, peer_ + " takes no bytes any more"};
    if (greeted_ && !paused_ && now >= heard_ + seconds(bounds_.dead_seconds))
        return Closed{CloseReason::silent, {}, {}, peer_ + " has been silent for too long"};
    return {};
}

Connection::Clock::time_point Connection::next_look(Clock::time_point now) const {
    if (state_ == State::finishing) return finishing_since_ + seconds(bounds_.goodbye_seconds);
    auto next = now + seconds(bounds_.dead_seconds);
    if (!greeted_) next = std::min(next, started_ + seconds(bounds_.first_message_seconds));
    if (greeted_ && !paused_) next = std::min(next, heard_ + seconds(bounds_.dead_seconds));
    if (!outbox_.empty()) next = std::min(next, progressed_ + seconds(bounds_.dead_seconds));
    if (heartbeat_seconds_ > 0) next = std::min(next, beat_ + seconds(heartbeat_seconds_));
    return next;
}

}  // namespace lumenfarm::net
