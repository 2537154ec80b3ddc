#pragma once

#include "common/net/connection.h"
#include "common/net/listener.h"
#include "master/effects.h"

#include <boost/asio/io_context.hpp>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

/// The connections of a master, or of a relay to its workers: each is a session of the core.
namespace lumenfarm {

/// Who is told of them, from the io_context.
class PeerEvents {
public:
    virtual ~PeerEvents() = default;
    virtual void on_peer(SessionId session, const std::string& address) = 0;
    virtual void on_peer_message(SessionId session, wire::Message message, std::uint64_t request_id) = 0;
    virtual void on_peer_gone(SessionId session) = 0;
    /// A connection ended, of a session or of one that was left.
    virtual void on_peer_closed(const net::Closed& closed) = 0;
    virtual void on_accept_failed(const std::string& why) = 0;
};

class PeerSessions : public net::ConnectionHandler {
public:
    PeerSessions(boost::asio::io_context& io, PeerEvents& events) : io_(io), events_(events) {}

    /// Errors: bad_input (address; not loopback without allow_plaintext), failed (port busy).
    Result<void> listen(const std::string& where, bool allow_plaintext);
    void stop_listening() { listener_.reset(); }
    /// No more events.
    void detach();

    // The core's effects. A session that is gone is left alone.
    void carry_out(const Send& send);
    void carry_out(const Close& close);

    /// Reading of a peer pauses while many of its requests wait for the disk.
    void begin_slow_request(SessionId session);
    void end_slow_request(SessionId session);

    std::uint16_t port() const { return port_; }
    const std::string& address() const { return address_; }  ///< "ADDRESS:PORT"
    bool empty() const { return peers_.empty(); }
    /// With workers and relays, since the start.
    wire::Traffic traffic() const;

    void on_message(net::Connection& connection, wire::Envelope envelope) override;
    void on_close(net::Connection& connection, const net::Closed& closed) override;

private:
    struct Peer {
        std::shared_ptr<net::Connection> connection;
        SessionId session = 0;  ///< 0: the core has let go of it
        wire::Role role = wire::Role::submitter;
        std::size_t slow_requests = 0;  ///< that the disk has not answered
    };

    void accept(boost::asio::ip::tcp::socket socket);
    Peer* peer_of(SessionId session);
    void let_go(SessionId session);

    boost::asio::io_context& io_;
    PeerEvents& events_;
    std::unique_ptr<net::Listener> listener_;
    std::string address_;
    std::uint16_t port_ = 0;
    std::map<net::Connection*, Peer> peers_;
    std::map<SessionId, net::Connection*> sessions_;
    wire::Traffic traffic_of_closed_;
    SessionId next_session_ = embedding_session + 1;
};

}  // namespace lumenfarm
