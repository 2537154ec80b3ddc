#pragma once

#include "master/commit_queue.h"
#include "master/master_core.h"
#include "master/storage.h"
#include "tests/simulation/farm_checks.h"
#include "tests/simulation/simulated_disk.h"
#include "tests/simulation/simulated_vfs.h"
#include "tests/simulation/world.h"

#include <cstdint>
#include <map>
#include <memory>

/// The master's machine: the real core and the real storage in processes that come and go, on one disk.
namespace lumenfarm::testing {

struct MasterConditions {
    double disk_failures = 0;  ///< chance that a write or a sync fails, which ends the process
    double checkpoint_seconds = 10;
    double recut_seconds = 10;
    double audit_fraction = 0;
    double down_s = 0.1;    ///< between two processes, on the average
    double bad_chunks = 0;  ///< chance that a chunk of the scene comes damaged to a worker
};

class SimulatedMaster : public NetworkEnd {
public:
    SimulatedMaster(World& world, FarmChecks& checks, std::uint64_t seed, const MasterConditions& conditions);

    /// A new process, with what the disk has left. REQUIRES: none runs.
    void start();
    /// The process ends: killed, or with the power of its machine. The next one follows.
    void end(bool machine_too);
    /// The power fails during one of the next calls of the disk.
    void cut_power_soon() { disk_.crash_at(world_.chance.number(1, 12)); }
    void fill_disk(double seconds);

    /// The disk fails no more, and has room.
    void calm_disk();
    bool disk_works() const { return disk_free_ && disk_failures_ == 0; }

    MasterCore* core() { return core_.get(); }  ///< null: no process runs
    const MasterCore* core() const { return core_.get(); }
    FileStore& files() { return storage_->files(); }
    std::uint64_t lives() const { return lives_; }
    std::uint64_t snapshots() const { return snapshots_; }  ///< but for those when it ended
    double up_since_s() const { return up_since_s_; }
    void cancel(JobId job) { carry_out(core_->cancel(job, world_.now_s())); }

    void on_open(ConnectionId connection) override;
    void on_message(ConnectionId connection, wire::Message message, std::uint64_t request_id) override;
    void on_close(ConnectionId connection, const std::optional<wire::Goodbye>& goodbye) override;

private:
    void begin_life(std::unique_ptr<Storage> storage, Storage::Start start);
    void tick();
    /// The storage does `work` after what it was asked for before; then the core hears of it.
    template <class Work, class Then>
    void slowly(Work work, Then then);
    void commit(bool leases_too);

    void carry_out(Effects effects);
    void carry_out(Send& send);
    void carry_out(Close& close);
    void carry_out(Admit& admit);
    void carry_out(StoreChunk& store);
    void carry_out(ServeManifest& serve);
    void carry_out(ServeChunk& serve);
    void carry_out(Prepare& prepare);
    void carry_out(MeasureCut& measure);
    void carry_out(StoreResult& store);
    void carry_out(StoreLeases& leases) { commits_.add(leases); }
    void carry_out(StoreSnapshot& store);
    void carry_out(StoreRecord& store);
    void carry_out(Retract& retract);
    void carry_out(PutAside& aside);
    void carry_out(RemoveJob& remove);
    void carry_out(StoreSolution& store);
    void carry_out(Discarded&) {}

    World& world_;
    FarmChecks& checks_;
    MasterConditions conditions_;
    SimulatedDisk disk_;
    SimulatedVfs vfs_;
    SnapshotRule snapshot_rule_;  ///< jobs are small: at each checkpoint, when results outweigh sums, or as ever
    bool disk_free_ = true;
    double disk_failures_ = 0;
    std::unique_ptr<Storage> storage_;
    std::unique_ptr<MasterCore> core_;
    std::map<ConnectionId, wire::Hello> sessions_;  ///< that are open; those that have said Hello have an instance
    std::uint64_t lives_ = 0;
    std::uint64_t snapshots_ = 0;
    double up_since_s_ = 0;
    CommitQueue commits_;
    double storage_free_s_ = 0;  ///< when it has done what it was asked for
    bool last_chunk_was_bad_ = false;
};

}  // namespace lumenfarm::testing
