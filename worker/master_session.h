#pragma once

#include "common/net/connection.h"
#include "common/net/connector.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>

/// The connection of a worker, or of a relay, to its master: had again whenever it is lost.
namespace lumenfarm {

/// Who is told of it, from the io_context.
class MasterEvents {
public:
    virtual ~MasterEvents() = default;
    /// The connection is there: a Hello is due.
    virtual void on_master_open() = 0;
    virtual void on_master_message(wire::Message message) = 0;
    virtual void on_master_lost(const net::Closed& closed) = 0;
    /// After finish(): the last bytes have left.
    virtual void on_master_finished(const std::optional<net::Closed>& closed) = 0;
    /// The next part of a result, asked for while the connection has room.
    virtual std::optional<wire::Message> next_bulk() = 0;
};

class MasterSession : public net::ConnectionHandler {
public:
    /// `seed`: of the waits between attempts.
    MasterSession(boost::asio::io_context& io, net::HostPort master, std::uint64_t seed, MasterEvents& events)
        : io_(io), events_(events), master_(std::move(master)), retry_timer_(io), random_(seed) {}
    ~MasterSession() override;

    /// Tries until finish().
    void connect();
    void send(const wire::Message& message);
    /// Sends parts of results while the connection takes them.
    void pump();
    /// Says Goodbye, if there is a connection, and tries no more.
    void finish(const wire::Goodbye& goodbye);

    bool welcome() const { return welcome_; }  ///< any thread may ask
    const net::HostPort& master() const { return master_; }

    void on_message(net::Connection& connection, wire::Envelope envelope) override;
    void on_close(net::Connection& connection, const net::Closed& closed) override;
    void on_outbox_low(net::Connection&) override { pump(); }

private:
    void on_connected(Result<net::Connection::Socket> socket);
    void connect_later();

    boost::asio::io_context& io_;
    MasterEvents& events_;
    net::HostPort master_;
    boost::asio::steady_timer retry_timer_;
    std::mt19937_64 random_;
    std::unique_ptr<net::Connector> connector_;
    std::shared_ptr<net::Connection> connection_;
    unsigned attempts_ = 0;
    bool said_absent_ = false;
    bool finishing_ = false;
    std::atomic<bool> welcome_ = false;
};

}  // namespace lumenfarm
