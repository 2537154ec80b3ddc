#pragma once

#include "proto/messages.h"
#include "tests/simulation/chance.h"
#include "tests/simulation/event_queue.h"
#include "tests/simulation/history.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>

/// TCP between a master and its peers over a network that is against them, with the shells' watchdogs
/// (common/net/connection.h) and the times of limits.h. What it does, and what it can't do since TCP does not:
///
/// - *delay*: each message takes its own time, now and then seconds. One connection keeps the order of each direction.
/// - *reorder*: only between connections. What a peer sent over its old connection may arrive after the Hello of its
///   new one, as bytes do that wait in the kernels when a program gives its connection up.
/// - *duplicate*: never within a connection. A peer that has lost its answer asks the same over a new connection, and
///   the first question arrives nevertheless.
/// - *drop*: only with the connection. cut() takes it away with what was on its way: in each direction a part of it
///   arrives still, and the rest never does.
/// - *half-open*: the ends learn of a loss on their own, one of them often by nothing but the other's silence.
/// - *partition*: block() stops one or both directions of a host. TCP sends again when it ends, unless somebody has
///   given up before: who is silent for dead_seconds, or does not take what was sent for that long, is given up.
namespace lumenfarm::testing {

using ConnectionId = std::uint64_t;  ///< 1, 2, ...; the master's session has the same number
using HostId = std::size_t;          ///< a machine beside the master's

enum class Side : std::uint8_t { master, peer };
constexpr Side other(Side side) { return side == Side::master ? Side::peer : Side::master; }

/// A process that has ends of connections. Outlives them, or leaves them by one of the calls that end connections.
class NetworkEnd {
public:
    virtual ~NetworkEnd() = default;
    virtual void on_open(ConnectionId connection) = 0;
    /// Goodbyes are not messages here, as with net::Connection; heartbeats are, and were answered.
    virtual void on_message(ConnectionId connection, wire::Message message, std::uint64_t request_id) = 0;
    /// The last call for this connection: lost, or left by the other side, or never opened.
    virtual void on_close(ConnectionId connection, const std::optional<wire::Goodbye>& goodbye) = 0;
};

class SimulatedNetwork {
public:
    SimulatedNetwork(EventQueue& clock, Chance& chance, History& history)
        : clock_(clock), chance_(chance), history_(history) {}

    /// Messages take up to `usual_s`, and one in a hundred `spike_s` more on the average.
    void set_latency(double usual_s, double spike_s) { usual_s_ = usual_s, spike_s_ = spike_s; }

    /// The master's process; null: it is gone, and nobody is let in.
    void listen(NetworkEnd* master) { master_ = master; }
    /// Answered by on_open or on_close, at the latest after connect_seconds.
    ConnectionId connect(HostId host, NetworkEnd& peer);
    /// Nothing happens when the end is closed already.
    void send(ConnectionId id, Side from, wire::Message message, std::uint64_t request_id = 0);
    /// True while so much is on its way that only short messages should follow.
    bool congested(ConnectionId id, Side from) const;

    // An end leaves. It hears nothing more of the connection, not even on_close.
    /// Says Goodbye, after all that it has sent.
    void close(ConnectionId id, Side side, const wire::Goodbye& goodbye);
    /// Its process is killed: the kernel says so, and may forget what has not left.
    void kill(ConnectionId id, Side side);
    /// Its machine has lost its power: nobody says anything.
    void vanish(ConnectionId id, Side side);

    /// The network loses every connection of the host.
    void cut(HostId host);
    /// Nothing of the host's reaches `to` for so long.
    void block(HostId host, Side to, double seconds);
    bool blocked(HostId host, Side to) const;
    std::size_t connections() const { return connections_.size(); }

private:
    struct Packet {
        double sent_s = 0;
        double arrives_s = 0;
        std::optional<wire::Message> message;  ///< none: the end of the stream
        std::uint64_t request_id = 0;
    };
    /// What is on its way to one end.
    struct Stream {
        std::deque<Packet> packets;
        double last_arrival_s = 0;
        bool lost = false;  ///< nothing more comes in
    };
    struct End {
        NetworkEnd* process = nullptr;  ///< null: closed
        Stream incoming;
        bool greeted = false;  ///< something has come
        bool beats = false;    ///< sends heartbeats
        double heard_s = 0;
        std::uint64_t beats_sent = 0;
    };
    struct Connection {
        HostId host = 0;
        std::array<End, 2> ends;
        End& end(Side side) { return ends[static_cast<std::size_t>(side)]; }
    };

    double latency_s();
    Connection* find(ConnectionId id);
    End* open_end(ConnectionId id, Side side);
    void establish(ConnectionId id, double give_up_s);
    void push(ConnectionId id, Side to, std::optional<wire::Message> message, std::uint64_t request_id);
    void pump(ConnectionId id, Side to);
    void deliver(ConnectionId id, Side to, Packet packet);
    void take(ConnectionId id, Side at, wire::Message message, std::uint64_t request_id);
    void open_session(ConnectionId id, Side side);
    void beat(ConnectionId id, Side side);
    void watch(ConnectionId id, Side side);
    void lose_tail(Stream& stream);
    /// The end learns that the connection is gone.
    void fail(ConnectionId id, Side side, std::string_view why, const std::optional<wire::Goodbye>& goodbye = {});
    void forget_if_over(ConnectionId id);
    void note(ConnectionId id, std::string_view what, std::initializer_list<std::uint64_t> numbers = {}) {
        history_.note(clock_.now_s(), Who::network, id, what, numbers);
    }

    EventQueue& clock_;
    Chance& chance_;
    History& history_;
    double usual_s_ = 0.05;
    double spike_s_ = 0;
    NetworkEnd* master_ = nullptr;
    std::map<ConnectionId, Connection> connections_;
    ConnectionId last_id_ = 0;
    std::map<std::pair<HostId, Side>, double> blocked_until_s_;
};

}  // namespace lumenfarm::testing
