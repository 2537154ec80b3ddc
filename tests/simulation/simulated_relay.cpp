#include "tests/simulation/simulated_relay.h"

#include "common/net/connector.h"
#include "common/scene/scene_file.h"
#include "common/support/ensure.h"
#include "relay/prepare_lent.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::testing {

namespace {

constexpr double tick_s = 0.2;
constexpr std::uint64_t fingerprint = 7;

}  // namespace

SimulatedRelay::SimulatedRelay(World& world, FarmChecks& checks, std::size_t index, SimulatedNetwork& above,
                               std::size_t bytes_in_flight)
    : world_(world),
      checks_(checks),
      index_(index),
      above_(above),
      bytes_in_flight_(bytes_in_flight),
      below_(world.clock, world.chance, world.history) {}

void SimulatedRelay::start(WorkerId instance) {
    ensure(!core_, "one process at a time");
    ++life_;
    instance_ = instance;
    attempts_ = 0;
    files_.clear();
    up_since_s_ = world_.now_s();
    world_.note(Who::relay, index_, "starts as instance", {instance});
    relay::RelayIdentity identity;
    identity.name = "relay " + std::to_string(index_);
    identity.instance = instance;
    identity.fingerprint = fingerprint;
    MasterPolicy farm;
    farm.fingerprint = fingerprint;
    farm.epoch = static_cast<std::uint32_t>(instance);
    farm.upstream = "the master";
    farm.instance = instance;
    core_ = std::make_unique<relay::RelayCore>(identity, farm, limits::drain_seconds, bytes_in_flight_);
    below_.listen(&lower_);
    connect();
    tick();
}

void SimulatedRelay::end(bool machine_too) {
    if (!core_) return;
    world_.note(Who::relay, index_, machine_too ? "loses its power" : "is killed");
    leave(machine_too);
}

void SimulatedRelay::leave(bool machine_too) {
    below_.listen(nullptr);
    for (const ConnectionId id : std::exchange(sessions_, {}))
        machine_too ? below_.vanish(id, Side::master) : below_.kill(id, Side::master);
    machine_too ? above_.vanish(connection_, Side::peer) : above_.kill(connection_, Side::peer);
    connection_ = 0;
    ++life_;
    core_.reset();
}

void SimulatedRelay::later(double delay_s, std::function<void()> event) {
    world_.clock.after(delay_s, [this, life = life_, event = std::move(event)] {
        if (life == life_) event();
    });
}

void SimulatedRelay::tick() {
    later(tick_s, [this] {
        tick();
        carry_out(core_->tick(world_.now_s()));
    });
}

// The networks

void SimulatedRelay::connect() { connection_ = above_.connect(host(), upper_); }

void SimulatedRelay::Upper::on_open(ConnectionId) {
    relay.carry_out(relay.core_->on_upstream_open(relay.world_.now_s()));
}

void SimulatedRelay::Upper::on_message(ConnectionId, wire::Message message, std::uint64_t) {
    if (std::holds_alternative<wire::Welcome>(message)) relay.attempts_ = 0;
    relay.carry_out(relay.core_->on_upstream_message(std::move(message), relay.world_.now_s()));
}

void SimulatedRelay::Upper::on_close(ConnectionId, const std::optional<wire::Goodbye>& goodbye) {
    relay.connection_ = 0;
    relay.later(net::reconnect_delay_seconds(relay.attempts_++, relay.world_.chance.uniform(0, 1)),
                [&relay = relay] { relay.connect(); });
    relay.carry_out(relay.core_->on_upstream_lost(goodbye, relay.world_.now_s()));
}

void SimulatedRelay::Lower::on_open(ConnectionId connection) {
    relay.sessions_.insert(connection);
    relay.carry_out(relay.core_->on_connect(connection, "10.0.0.1:1", relay.world_.now_s()));
}

void SimulatedRelay::Lower::on_message(ConnectionId connection, wire::Message message, std::uint64_t request_id) {
    relay.carry_out(relay.core_->on_message(connection, std::move(message), request_id, relay.world_.now_s()));
}

void SimulatedRelay::Lower::on_close(ConnectionId connection, const std::optional<wire::Goodbye>&) {
    relay.sessions_.erase(connection);
    relay.carry_out(relay.core_->on_disconnect(connection, relay.world_.now_s()));
}

// The core's effects

void SimulatedRelay::carry_out(relay::Effects effects) {
    const std::uint64_t life = life_;
    for (relay::Effect& effect : effects)
        if (life == life_) std::visit([&](auto& each) { carry_out(each); }, effect);
    while (life == life_ && connection_ != 0 && !above_.congested(connection_, Side::peer)) {
        auto part = core_->next_bulk();
        if (!part) return;
        send_up(std::move(*part));
    }
}

void SimulatedRelay::send_up(wire::Message message) {
    if (const auto* done = std::get_if<wire::ResultDone>(&message)) checks_.on_offer(instance_, *done);
    above_.send(connection_, Side::peer, std::move(message));
}

void SimulatedRelay::carry_out(relay::SendUp& send) { send_up(std::move(send.message)); }

void SimulatedRelay::carry_out(Send& send) {
    if (!sessions_.contains(send.session)) return;
    if (const auto* goodbye = std::get_if<wire::Goodbye>(&send.message))
        return below_.close(send.session, Side::master, *goodbye);
    if (const auto* ack = std::get_if<wire::ResultAck>(&send.message))
        if (ack->verdict == wire::Verdict::invalid)
            checks_.violated("a relay calls an honest result impossible: " + ack->sentence);
    below_.send(send.session, Side::master, std::move(send.message), send.request_id);
}

void SimulatedRelay::carry_out(Close& close) {
    if (sessions_.erase(close.session) > 0)
        below_.close(close.session, Side::master, wire::Goodbye(wire::GoodbyeReason::done));
}

void SimulatedRelay::carry_out(ServeManifest& serve) {
    later(world_.chance.uniform(0.001, 0.1), [this, serve] {
        const auto file = files_.find(serve.file);
        wire::Message reply = wire::Refusal(wire::RefusalReason::no_such_file, "it is not here", serve.file);
        if (file != files_.end())
            reply = wire::Manifest(wire::FileManifest(serve.file, file->second->size(), chunk_digests(*file->second)));
        carry_out(core_->on_served(serve.session, std::move(reply), serve.request_id, world_.now_s()));
    });
}

void SimulatedRelay::carry_out(ServeChunk& serve) {
    later(world_.chance.uniform(0.001, 0.1), [this, serve] {
        const auto file = files_.find(serve.file);
        const std::size_t begin = serve.index * limits::chunk_bytes;
        wire::Message reply = wire::Refusal(wire::RefusalReason::no_such_file, "it is not here", serve.file);
        if (file != files_.end() && begin < file->second->size()) {
            const auto& bytes = *file->second;
            const std::size_t end = std::min(bytes.size(), begin + limits::chunk_bytes);
            reply = wire::Chunk(serve.file, serve.index, {bytes.data() + begin, bytes.data() + end});
        }
        carry_out(core_->on_served(serve.session, std::move(reply), serve.request_id, world_.now_s()));
    });
}

void SimulatedRelay::carry_out(relay::KeepFile& keep) {
    later(world_.chance.uniform(0.001, 0.1), [this, keep] {
        files_[keep.file] = keep.bytes;
        carry_out(core_->on_file_kept(keep.file, {}, world_.now_s()));
    });
}

void SimulatedRelay::carry_out(relay::PrepareLent& prepare) {
    later(0.1, [this, prepare] {
        const auto read = [&](const Digest& file) -> Result<std::vector<std::byte>> {
            const auto found = files_.find(file);
            if (found == files_.end()) return failed("file " + file.hex() + " is not here");
            return *found->second;
        };
        carry_out(core_->on_prepared(prepare.info, relay::prepare_lent(prepare, read), world_.now_s()));
    });
}

void SimulatedRelay::carry_out(relay::Finished&) {
    world_.note(Who::relay, index_, "has nothing left to do");
    carry_out(core_->dismiss(world_.now_s()));
    above_.close(connection_, Side::peer, wire::Goodbye(wire::GoodbyeReason::done));
    leave(false);
}

void SimulatedRelay::carry_out(relay::GiveUp& give_up) {
    checks_.violated("a relay gives up: " + give_up.sentence);
    leave(false);
}

}  // namespace lumenfarm::testing
