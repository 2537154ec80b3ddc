#pragma once

#include "tests/simulation/farm_checks.h"
#include "tests/simulation/world.h"
#include "worker/worker_core.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <vector>

/// A worker's machine: the real core and the real slots behind a fake tracer, in processes that come and go.
namespace lumenfarm::testing {

class SimulatedWorker : public NetworkEnd {
public:
    /// `network`: where its master listens. `memory_bytes`: 0 is no limit.
    SimulatedWorker(World& world, FarmChecks& checks, SimulatedNetwork& network, std::size_t index,
                    std::uint32_t threads, std::uint64_t memory_bytes, bool parts_only)
        : world_(world),
          checks_(checks),
          network_(network),
          index_(index),
          threads_(threads),
          memory_bytes_(memory_bytes),
          parts_only_(parts_only) {}

    /// A new process; a slice of a set takes it `slice_s`. REQUIRES: none runs.
    void start(WorkerId instance, double slice_s);
    /// The process is gone: killed, or with its machine.
    void end(bool machine_too);
    /// From the next process on one of so many slices is wrong.
    void lie(std::uint64_t one_in) { lies_one_in_ = one_in; }
    void drain() { carry_out(core_->drain(world_.now_s())); }

    bool alive() const { return core_ && !drained_; }
    bool drained() const { return drained_; }
    /// A worker that is so slow lives, and traces nothing worth waiting for.
    bool traces() const { return alive() && slice_s_ < 10; }
    const worker::WorkerCore* core() const { return core_.get(); }
    HostId host() const { return host_of_worker(index_); }

    void on_open(ConnectionId connection) override;
    void on_message(ConnectionId connection, wire::Message message, std::uint64_t request_id) override;
    void on_close(ConnectionId connection, const std::optional<wire::Goodbye>& goodbye) override;

private:
    struct SlotRun {
        std::unique_ptr<TraceSlot> slot;
        SlotAsk interrupt = SlotAsk::nothing;
        bool busy = false;
    };

    /// An event of this process; nothing when it is gone by then.
    void later(double delay_s, std::function<void()> event);
    void connect_later();
    void tick();
    void slice(std::size_t slot, SlotAsk ask);
    void obey(std::size_t slot, SlotAsk ask);

    void carry_out(worker::Effects effects);
    void carry_out(worker::Send& send);
    void carry_out(worker::StartSlot& start);
    void carry_out(worker::ContinueSlot& effect) { obey(effect.slot, SlotAsk::nothing); }
    void carry_out(worker::TellSlot& tell) { obey(tell.slot, tell.ask); }
    void carry_out(worker::InterruptSlot& interrupt);
    void carry_out(worker::LoadScene& load);
    void carry_out(worker::KeepScene& keep) { cache_[keep.scene] = keep.bytes; }
    void carry_out(worker::PrepareJob& prepare);
    void carry_out(worker::PreparePart& prepare);
    void carry_out(worker::Finished&);
    void carry_out(worker::Discarded&) {}
    void carry_out(worker::GiveUp& give_up);
    void send(wire::Message message);

    World& world_;
    FarmChecks& checks_;
    SimulatedNetwork& network_;
    std::size_t index_;
    std::uint32_t threads_;
    std::uint64_t memory_bytes_;
    bool parts_only_;
    std::unique_ptr<worker::WorkerCore> core_;
    WorkerId instance_ = 0;
    double slice_s_ = 0;
    std::uint64_t life_ = 0;  ///< events of an earlier process are dropped
    ConnectionId connection_ = 0;
    unsigned attempts_ = 0;
    std::uint64_t sessions_ = 0, files_missed_ = 0, files_asked_ = 0;  ///< of this process
    bool drained_ = false;
    std::uint64_t lies_one_in_ = 0;
    std::vector<SlotRun> slots_;
    std::map<Digest, std::shared_ptr<const std::vector<std::byte>>> cache_;  ///< of the machine
};

}  // namespace lumenfarm::testing
