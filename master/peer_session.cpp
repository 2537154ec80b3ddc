#include "master/peer_session.h"

#include <spdlog/spdlog.h>

#include <utility>

namespace lumenfarm {

namespace {

constexpr std::size_t slow_requests_max = 8;  ///< of one connection, before its reading pauses

void add(wire::Traffic& sum, const net::ConnectionCounters& connection) {
    sum.bytes_in += connection.bytes_in;
    sum.bytes_out += connection.bytes_out;
    sum.messages_in += connection.messages_in;
    sum.messages_out += connection.messages_out;
}

}  // namespace

Result<void> PeerSessions::listen(const std::string& where, bool allow_plaintext) {
    const auto address = net::HostPort::parse(where);
    if (!address) return address.error();
    auto listener = net::Listener::open(
        io_, *address, [this](boost::asio::ip::tcp::socket socket) { accept(std::move(socket)); },
        [this](const std::string& why) { events_.on_accept_failed(why); });
    if (!listener) return listener.error();
    if (!(*listener)->on_loopback() && !allow_plaintext)
        return bad_input("'" + where +
                         "' is reached from other machines and nothing is encrypted or authenticated there: add "
                         "--allow-plaintext if everybody in that network may use this farm");
    listener_ = std::move(*listener);
    address_ = net::text_of(listener_->local());
    port_ = listener_->local().port();
    return {};
}

void PeerSessions::detach() {
    for (auto& [connection, peer] : peers_) peer.connection->detach();
}

void PeerSessions::accept(boost::asio::ip::tcp::socket socket) {
    auto connection = net::Connection::make(std::move(socket), net::Connection::stranger(), *this);
    const SessionId session = next_session_++;
    peers_.emplace(connection.get(), Peer{connection, session});
    sessions_.emplace(session, connection.get());
    connection->start();
    events_.on_peer(session, connection->peer());
}

void PeerSessions::on_message(net::Connection& connection, wire::Envelope envelope) {
    Peer& peer = peers_.at(&connection);
    if (peer.session == 0) return;
    if (const auto* hello = std::get_if<wire::Hello>(&envelope.message)) {
        peer.role = hello->role;
        spdlog::info("{} '{}' connects from {} with {} threads", name_of(hello->role), hello->name, connection.peer(),
                     hello->threads);
    }
    events_.on_peer_message(peer.session, std::move(envelope.message), envelope.request_id);
}

void PeerSessions::on_close(net::Connection& connection, const net::Closed& closed) {
    const auto peer = peers_.find(&connection);
    if (peer == peers_.end()) return;
    spdlog::info("{} is gone ({})", connection.peer(), closed.text());
    if (wire::pulls_work(peer->second.role)) add(traffic_of_closed_, connection.counters());
    const SessionId session = peer->second.session;
    if (session != 0) let_go(session);
    peers_.erase(peer);
    if (session != 0 && closed.goodbye) events_.on_peer_message(session, *closed.goodbye, 0);
    if (session != 0) events_.on_peer_gone(session);
    events_.on_peer_closed(closed);
}

wire::Traffic PeerSessions::traffic() const {
    wire::Traffic all = traffic_of_closed_;
    for (const auto& [connection, peer] : peers_)
        if (wire::pulls_work(peer.role)) add(all, connection->counters());
    return all;
}

PeerSessions::Peer* PeerSessions::peer_of(SessionId session) {
    const auto found = sessions_.find(session);
    return found == sessions_.end() ? nullptr : &peers_.at(found->second);
}

void PeerSessions::let_go(SessionId session) {
    if (Peer* peer = peer_of(session)) peer->session = 0;
    sessions_.erase(session);
}

void PeerSessions::carry_out(const Send& send) {
    Peer* peer = peer_of(send.session);
    if (!peer) return;
    net::Connection& connection = *peer->connection;
    if (const auto* goodbye = std::get_if<wire::Goodbye>(&send.message)) {
        spdlog::info("goodbye to {} ({}): {}", connection.peer(), name_of(goodbye->reason), goodbye->text);
        connection.finish(*goodbye);
        return;
    }
    if (const auto* refusal = std::get_if<wire::Refusal>(&send.message))
        spdlog::info("a request of {} is refused ({}): {}", connection.peer(), name_of(refusal->reason),
                     refusal->sentence);
    connection.send(send.message, send.request_id);
    if (const auto* welcome = std::get_if<wire::Welcome>(&send.message))
        connection.open_session(wire::pulls_work(peer->role) ? wire::from_worker : wire::from_submitter, {},
                                welcome->heartbeat_seconds, welcome->dead_seconds);
}

void PeerSessions::carry_out(const Close& close) {
    Peer* peer = peer_of(close.session);
    if (!peer) return;
    const auto connection = peer->connection;
    let_go(close.session);
    connection->finish(wire::Goodbye(wire::GoodbyeReason::done));
}

void PeerSessions::begin_slow_request(SessionId session) {
    Peer* peer = peer_of(session);
    if (peer && ++peer->slow_requests == slow_requests_max) peer->connection->pause_reading();
}

void PeerSessions::end_slow_request(SessionId session) {
    Peer* peer = peer_of(session);
    if (peer && peer->slow_requests-- == slow_requests_max) peer->connection->resume_reading();
}

}  // namespace lumenfarm
