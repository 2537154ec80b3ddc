#include "tests/bench/farm_load.h"

#include "proto/messages.h"

#include <boost/asio/post.hpp>

#include <utility>

namespace lumenfarm::bench {
namespace {

/// Ours are told from those of the connection itself.
constexpr std::uint64_t first_sequence = std::uint64_t{1} << 32;

}  // namespace

IdleSessions::IdleSessions(boost::asio::io_context& io, net::HostPort master, std::uint64_t fingerprint,
                           double beat_seconds)
    : io_(io), master_(std::move(master)), fingerprint_(fingerprint), beat_seconds_(beat_seconds) {}

IdleSessions::~IdleSessions() {
    for (auto& [connection, session] : sessions_) connection->detach();
}

void IdleSessions::keep(std::size_t count) {
    wanted_ = count;
    if (!connector_ && sessions_.size() < wanted_) connect();
}

void IdleSessions::connect() {
    connector_ = std::make_unique<net::Connector>(io_, master_, limits::connect_seconds,
                                                  [this](Result<net::Connection::Socket> socket) {
                                                      if (socket) greet(std::move(*socket));
                                                      // the connector may not be replaced from within its own call
                                                      boost::asio::post(io_, [this] {
                                                          connector_.reset();
                                                          keep(wanted_);
                                                      });
                                                  });
}

void IdleSessions::greet(net::Connection::Socket socket) {
    auto connection = net::Connection::make(std::move(socket), net::Connection::greeted(), *this);
    sessions_[connection.get()] = {connection, std::make_unique<boost::asio::steady_timer>(io_), {}, 0};
    connection->start();
    wire::Hello hello(wire::Role::worker, "idle", ++greeted_ | random_() << 32);
    hello.threads = 1;
    hello.fingerprint = fingerprint_;
    connection->send(hello);
}

void IdleSessions::on_message(net::Connection& connection, wire::Envelope envelope) {
    Session& session = sessions_.at(&connection);
    if (const auto* welcome = std::get_if<wire::Welcome>(&envelope.message)) {
        connection.open_session(wire::from_master, {}, welcome->heartbeat_seconds, welcome->dead_seconds);
        connection.send(wire::Progress());
        ++open_;
        beat_later(&connection, std::uniform_real_distribution<double>(0, beat_seconds_)(random_));
    } else if (const auto* reply = std::get_if<wire::HeartbeatReply>(&envelope.message)) {
        if (reply->sequence != session.sequence) return;
        answers_.push_back(std::chrono::duration<double>(Clock::now() - session.asked).count());
    }
}

void IdleSessions::beat_later(net::Connection* connection, double seconds) {
    auto& timer = *sessions_.at(connection).timer;
    timer.expires_after(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)));
    timer.async_wait([this, connection](const boost::system::error_code& error) {
        if (error) return;
        Session& session = sessions_.at(connection);
        session.sequence = std::max(first_sequence, session.sequence + 1);
        session.asked = Clock::now();
        connection->send(wire::Heartbeat(session.sequence));
        beat_later(connection, beat_seconds_);
    });
}

void IdleSessions::on_close(net::Connection& connection, const net::Closed&) {
    ++lost_;
    if (open_ > 0) --open_;
    sessions_.erase(&connection);
    keep(wanted_);
}

}  // namespace lumenfarm::bench
