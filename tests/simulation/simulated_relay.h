#pragma once

#include "relay/relay_core.h"
#include "tests/simulation/farm_checks.h"
#include "tests/simulation/world.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

/// A relay's machine: the real core in processes that come and go, with a network of its own for its workers.
namespace lumenfarm::testing {

class SimulatedRelay {
public:
    /// `above`: where its master listens; that of the farm, or of another relay.
    SimulatedRelay(World& world, FarmChecks& checks, std::size_t index, SimulatedNetwork& above,
                   std::size_t bytes_in_flight);

    /// A new process. REQUIRES: none runs.
    void start(WorkerId instance);
    /// The process is gone: killed, or with its machine.
    void end(bool machine_too);
    void drain() { carry_out(core_->drain(world_.now_s())); }

    bool alive() const { return core_ != nullptr; }
    const relay::RelayCore* core() const { return core_.get(); }
    HostId host() const { return host_of_relay(index_); }
    SimulatedNetwork& below() { return below_; }
    double up_since_s() const { return up_since_s_; }

private:
    /// The end of its connection to the master above.
    struct Upper : NetworkEnd {
        explicit Upper(SimulatedRelay& relay_) : relay(relay_) {}
        void on_open(ConnectionId) override;
        void on_message(ConnectionId, wire::Message message, std::uint64_t) override;
        void on_close(ConnectionId, const std::optional<wire::Goodbye>& goodbye) override;
        SimulatedRelay& relay;
    };
    /// The ends of those of its workers.
    struct Lower : NetworkEnd {
        explicit Lower(SimulatedRelay& relay_) : relay(relay_) {}
        void on_open(ConnectionId connection) override;
        void on_message(ConnectionId connection, wire::Message message, std::uint64_t request_id) override;
        void on_close(ConnectionId connection, const std::optional<wire::Goodbye>&) override;
        SimulatedRelay& relay;
    };

    /// An event of this process; nothing when it is gone by then.
    void later(double delay_s, std::function<void()> event);
    void connect();
    void tick();
    void leave(bool machine_too);

    void carry_out(relay::Effects effects);
    void carry_out(relay::SendUp& send);
    void carry_out(Send& send);
    void carry_out(Close& close);
    void carry_out(ServeManifest& serve);
    void carry_out(ServeChunk& serve);
    void carry_out(relay::KeepFile& keep);
    void carry_out(relay::RemoveFile& remove) { files_.erase(remove.file); }
    void carry_out(relay::PrepareLent& prepare);
    void carry_out(relay::Finished&);
    void carry_out(relay::GiveUp& give_up);
    void carry_out(Discarded&) {}
    void carry_out(worker::Discarded&) {}
    void send_up(wire::Message message);

    World& world_;
    FarmChecks& checks_;
    std::size_t index_;
    SimulatedNetwork& above_;
    std::size_t bytes_in_flight_;
    SimulatedNetwork below_;
    Upper upper_{*this};
    Lower lower_{*this};
    std::unique_ptr<relay::RelayCore> core_;
    WorkerId instance_ = 0;
    std::uint64_t life_ = 0;  ///< events of an earlier process are dropped
    double up_since_s_ = 0;
    ConnectionId connection_ = 0;
    unsigned attempts_ = 0;
    std::set<ConnectionId> sessions_;
    std::map<Digest, std::shared_ptr<const std::vector<std::byte>>> files_;
};

}  // namespace lumenfarm::testing
