#include "tests/simulation/simulated_network.h"

#include "common/support/limits.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::testing {

namespace {

constexpr std::size_t packets_high = 64;  ///< on their way in one direction: more is congestion
constexpr double knock_again_s = 1;       ///< between two attempts of the kernel to open a connection
constexpr double resend_s = 1.5;          ///< at most, from a partition's end until TCP tries again

}  // namespace

double SimulatedNetwork::latency_s() {
    const double usual_s = chance_.uniform(0.001, usual_s_);
    return spike_s_ > 0 && chance_.happens(0.01) ? usual_s + chance_.exponential(spike_s_) : usual_s;
}

SimulatedNetwork::Connection* SimulatedNetwork::find(ConnectionId id) {
    const auto found = connections_.find(id);
    return found == connections_.end() ? nullptr : &found->second;
}

SimulatedNetwork::End* SimulatedNetwork::open_end(ConnectionId id, Side side) {
    Connection* connection = find(id);
    return connection && connection->end(side).process ? &connection->end(side) : nullptr;
}

bool SimulatedNetwork::blocked(HostId host, Side to) const {
    const auto found = blocked_until_s_.find({host, to});
    return found != blocked_until_s_.end() && clock_.now_s() < found->second;
}

// Opening

ConnectionId SimulatedNetwork::connect(HostId host, NetworkEnd& peer) {
    const ConnectionId id = ++last_id_;
    Connection& connection = connections_[id];
    connection.host = host;
    connection.end(Side::peer).process = &peer;
    const double give_up_s = clock_.now_s() + limits::connect_seconds;
    clock_.after(latency_s(), [this, id, give_up_s] { establish(id, give_up_s); });
    return id;
}

void SimulatedNetwork::establish(ConnectionId id, double give_up_s) {
    if (!open_end(id, Side::peer)) return forget_if_over(id);
    Connection& connection = *find(id);
    if (blocked(connection.host, Side::master) || blocked(connection.host, Side::peer)) {
        if (clock_.now_s() + knock_again_s >= give_up_s) return fail(id, Side::peer, "nobody answers");
        return clock_.after(knock_again_s, [this, id, give_up_s] { establish(id, give_up_s); });
    }
    if (!master_) return fail(id, Side::peer, "nobody listens");
    note(id, "opens, of host", {connection.host});
    connection.end(Side::master).process = master_;
    for (const Side side : {Side::master, Side::peer}) {
        End* end = open_end(id, side);
        if (!end) continue;
        end->heard_s = clock_.now_s();
        clock_.after(limits::hello_seconds, [this, id, side] { watch(id, side); });
        end->process->on_open(id);
    }
}

// Sending

void SimulatedNetwork::send(ConnectionId id, Side from, wire::Message message, std::uint64_t request_id) {
    if (!open_end(id, from)) return;
    const bool welcome = std::holds_alternative<wire::Welcome>(message);
    push(id, other(from), std::move(message), request_id);
    if (welcome) open_session(id, from);
}

bool SimulatedNetwork::congested(ConnectionId id, Side from) const {
    const auto found = connections_.find(id);
    return found == connections_.end() ||
           found->second.ends[static_cast<std::size_t>(other(from))].incoming.packets.size() >= packets_high;
}

void SimulatedNetwork::push(ConnectionId id, Side to, std::optional<wire::Message> message, std::uint64_t request_id) {
    Stream& stream = find(id)->end(to).incoming;
    if (stream.lost) return;
    const double now_s = clock_.now_s();
    stream.last_arrival_s = std::max(stream.last_arrival_s, now_s + latency_s());
    stream.packets.push_back({now_s, stream.last_arrival_s, std::move(message), request_id});
    clock_.at(stream.last_arrival_s, [this, id, to] { pump(id, to); });
}

/// What is due arrives, in its order.
void SimulatedNetwork::pump(ConnectionId id, Side to) {
    while (Connection* connection = find(id)) {
        Stream& stream = connection->end(to).incoming;
        const double now_s = clock_.now_s();
        if (stream.packets.empty() || stream.packets.front().arrives_s > now_s) break;
        if (now_s - stream.packets.front().sent_s > limits::dead_seconds) {
            // the kernel that holds them has given up (TCP_USER_TIMEOUT)
            stream.lost = true;
            stream.packets.clear();
            fail(id, other(to), "nothing is taken");
            break;
        }
        if (blocked(connection->host, to)) return;
        Packet packet = std::move(stream.packets.front());
        stream.packets.pop_front();
        deliver(id, to, std::move(packet));
    }
    forget_if_over(id);
}

void SimulatedNetwork::deliver(ConnectionId id, Side to, Packet packet) {
    End* end = open_end(id, to);
    if (!end) {
        // the kernel answers for a process that is gone
        return clock_.after(latency_s(), [this, id, to] {
            const Connection* connection = find(id);
            if (connection && !blocked(connection->host, other(to))) fail(id, other(to), "is reset");
        });
    }
    end->heard_s = clock_.now_s();
    if (!packet.message) return fail(id, to, "was closed by the other side");
    if (const auto* goodbye = std::get_if<wire::Goodbye>(&*packet.message)) {
        const wire::Goodbye said = *goodbye;
        return fail(id, to, "ends with a Goodbye", said);
    }
    take(id, to, std::move(*packet.message), packet.request_id);
}

void SimulatedNetwork::take(ConnectionId id, Side at, wire::Message message, std::uint64_t request_id) {
    End& end = *open_end(id, at);
    end.greeted = true;
    if (const auto* beat = std::get_if<wire::Heartbeat>(&message)) {
        push(id, other(at), wire::HeartbeatReply(beat->sequence), request_id);
    } else if (!std::holds_alternative<wire::HeartbeatReply>(message)) {
        note(id, wire::name_of(message), {static_cast<std::uint64_t>(at)});
    }
    if (std::holds_alternative<wire::Welcome>(message)) open_session(id, at);
    end.process->on_message(id, std::move(message), request_id);
}

// The watchdogs of the shells

void SimulatedNetwork::open_session(ConnectionId id, Side side) {
    End* end = open_end(id, side);
    if (!end || std::exchange(end->beats, true)) return;
    end->greeted = true;
    clock_.after(limits::heartbeat_seconds, [this, id, side] { beat(id, side); });
}

void SimulatedNetwork::beat(ConnectionId id, Side side) {
    End* end = open_end(id, side);
    if (!end) return;
    push(id, other(side), wire::Heartbeat(++end->beats_sent), 0);
    clock_.after(limits::heartbeat_seconds, [this, id, side] { beat(id, side); });
}

void SimulatedNetwork::watch(ConnectionId id, Side side) {
    End* end = open_end(id, side);
    if (!end) return;
    const double now_s = clock_.now_s();
    if (!end->greeted) return fail(id, side, "hears no greeting in time");
    if (now_s >= end->heard_s + limits::dead_seconds) return fail(id, side, "is silent");
    const Stream& outgoing = find(id)->end(other(side)).incoming;
    if (!outgoing.packets.empty() && now_s > outgoing.packets.front().sent_s + limits::dead_seconds)
        return fail(id, side, "nothing is taken");
    double next_s = end->heard_s + limits::dead_seconds;
    if (!outgoing.packets.empty()) next_s = std::min(next_s, outgoing.packets.front().sent_s + limits::dead_seconds);
    clock_.at(std::max(next_s, now_s + 0.1), [this, id, side] { watch(id, side); });
}

// Ends

void SimulatedNetwork::fail(ConnectionId id, Side side, std::string_view why,
                            const std::optional<wire::Goodbye>& goodbye) {
    End* end = open_end(id, side);
    if (!end) return;
    note(id, side == Side::master ? "the master's end" : "the peer's end");
    note(id, why);
    NetworkEnd* process = std::exchange(end->process, nullptr);
    push(id, other(side), std::nullopt, 0);
    process->on_close(id, goodbye);
    forget_if_over(id);
}

void SimulatedNetwork::close(ConnectionId id, Side side, const wire::Goodbye& goodbye) {
    End* end = open_end(id, side);
    if (!end) return;
    end->process = nullptr;
    push(id, other(side), wire::Goodbye(goodbye), 0);
    push(id, other(side), std::nullopt, 0);
    forget_if_over(id);
}

void SimulatedNetwork::kill(ConnectionId id, Side side) {
    End* end = open_end(id, side);
    if (!end) return;
    end->process = nullptr;
    lose_tail(find(id)->end(other(side)).incoming);
    push(id, other(side), std::nullopt, 0);
    forget_if_over(id);
}

void SimulatedNetwork::vanish(ConnectionId id, Side side) {
    End* end = open_end(id, side);
    if (!end) return;
    end->process = nullptr;
    Stream& outgoing = find(id)->end(other(side)).incoming;
    lose_tail(outgoing);
    outgoing.lost = true;
    forget_if_over(id);
}

/// Of what is on its way only the first part arrives.
void SimulatedNetwork::lose_tail(Stream& stream) { stream.packets.resize(chance_.number(0, stream.packets.size())); }

void SimulatedNetwork::cut(HostId host) {
    for (auto& [id, connection] : connections_) {
        if (connection.host != host) continue;
        note(id, "is cut");
        for (const Side side : {Side::master, Side::peer}) {
            Stream& stream = connection.end(side).incoming;
            lose_tail(stream);
            stream.lost = true;
            if (!chance_.happens(0.7)) continue;  // it learns from silence
            clock_.after(chance_.uniform(0, 1), [this, id = id, side] { fail(id, side, "is lost"); });
        }
    }
}

void SimulatedNetwork::block(HostId host, Side to, double seconds) {
    history_.note(clock_.now_s(), Who::network, 0,
                  to == Side::master ? "nothing leaves this host, for milliseconds"
                                     : "nothing reaches this host, for milliseconds",
                  {host, static_cast<std::uint64_t>(seconds * 1000)});
    double& until_s = blocked_until_s_[{host, to}];
    until_s = std::max(until_s, clock_.now_s() + seconds);
    clock_.at(until_s + chance_.uniform(0, resend_s), [this, host, to] {
        std::vector<ConnectionId> waiting;
        for (const auto& [id, connection] : connections_)
            if (connection.host == host) waiting.push_back(id);
        for (const ConnectionId id : waiting) pump(id, to);
    });
}

/// Both ends are closed, and nothing is on its way that somebody would answer.
void SimulatedNetwork::forget_if_over(ConnectionId id) {
    Connection* connection = find(id);
    if (connection && !connection->end(Side::master).process && !connection->end(Side::peer).process)
        connections_.erase(id);
}

}  // namespace lumenfarm::testing
