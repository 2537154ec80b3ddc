#pragma once

#include "common/net/connection.h"
#include "common/net/connector.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

/// Sessions of workers that have no room for sets, and ask the master how it is: each sends a Heartbeat of its own
/// every `beat_seconds` and measures when the answer comes.
namespace lumenfarm::bench {

class IdleSessions : public net::ConnectionHandler {
public:
    using Clock = std::chrono::steady_clock;

    /// `fingerprint`: of this machine's tracer, as the master wants it.
    IdleSessions(boost::asio::io_context& io, net::HostPort master, std::uint64_t fingerprint, double beat_seconds);
    ~IdleSessions() override;

    /// Opens `count` of them, some at a time, and keeps that many.
    void keep(std::size_t count);
    std::size_t open() const { return open_; }
    std::uint64_t lost() const { return lost_; }
    /// Seconds from heartbeat to answer, since the last call.
    std::vector<double> take_answers() { return std::exchange(answers_, {}); }

    void on_message(net::Connection& connection, wire::Envelope envelope) override;
    void on_close(net::Connection& connection, const net::Closed& closed) override;

private:
    struct Session {
        std::shared_ptr<net::Connection> connection;
        std::unique_ptr<boost::asio::steady_timer> timer;
        Clock::time_point asked;
        std::uint64_t sequence = 0;  ///< of the heartbeat whose answer is due; 0: none
    };
    void connect();
    void greet(net::Connection::Socket socket);
    void beat_later(net::Connection* connection, double seconds);

    boost::asio::io_context& io_;
    net::HostPort master_;
    std::uint64_t fingerprint_;
    double beat_seconds_;
    std::mt19937_64 random_{1};
    std::unique_ptr<net::Connector> connector_;
    std::map<net::Connection*, Session> sessions_;
    std::size_t wanted_ = 0, open_ = 0;
    std::uint64_t lost_ = 0, greeted_ = 0;
    std::vector<double> answers_;
};

}  // namespace lumenfarm::bench
