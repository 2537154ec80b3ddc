#include "worker/master_session.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

namespace lumenfarm {

MasterSession::~MasterSession() {
    if (connection_) connection_->detach();
}

void MasterSession::connect() {
    connector_ = std::make_unique<net::Connector>(
        io_, master_, limits::connect_seconds,
        [this](Result<net::Connection::Socket> socket) { on_connected(std::move(socket)); });
}

void MasterSession::on_connected(Result<net::Connection::Socket> socket) {
    if (!socket) {
        if (!std::exchange(said_absent_, true))
            spdlog::warn("{}; trying again until the master is there", socket.error().sentence);
        return connect_later();
    }
    connection_ = net::Connection::make(std::move(*socket), net::Connection::greeted(), *this);
    connection_->start();
    events_.on_master_open();
}

void MasterSession::connect_later() {
    const double uniform = std::uniform_real_distribution<double>(0, 1)(random_);
    const double delay_s = net::reconnect_delay_seconds(attempts_++, uniform);
    retry_timer_.expires_after(
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(delay_s)));
    retry_timer_.async_wait([this](const boost::system::error_code& error) {
        if (!error && !finishing_) connect();
    });
}

void MasterSession::on_message(net::Connection& connection, wire::Envelope envelope) {
    if (const auto* welcome = std::get_if<wire::Welcome>(&envelope.message)) {
        wire::FrameOptions options;
        options.protocol = welcome->protocol;
        options.compress = welcome->compress;
        connection.open_session(wire::from_master, options, welcome->heartbeat_seconds, welcome->dead_seconds);
        spdlog::info("welcome at {}", connection.peer());
        attempts_ = 0;
        said_absent_ = false;
        welcome_ = true;
    }
    events_.on_master_message(std::move(envelope.message));
}

void MasterSession::on_close(net::Connection&, const net::Closed& closed) {
    connection_.reset();
    welcome_ = false;
    if (finishing_) return events_.on_master_finished(closed);
    spdlog::warn("the master is gone ({})", closed.text());
    events_.on_master_lost(closed);
    if (!finishing_) connect_later();
}

void MasterSession::send(const wire::Message& message) {
    if (connection_) connection_->send(message);
}

void MasterSession::pump() {
    while (connection_ && connection_->open() && !connection_->congested()) {
        const auto part = events_.next_bulk();
        if (!part) return;
        connection_->send(*part);
    }
}

void MasterSession::finish(const wire::Goodbye& goodbye) {
    finishing_ = true;
    welcome_ = false;
    connector_.reset();
    retry_timer_.cancel();
    if (connection_ && connection_->open()) {
        connection_->finish(goodbye);
    } else {
        events_.on_master_finished(std::nullopt);
    }
}

}  // namespace lumenfarm
