#include "tests/simulation/simulated_master.h"

#include <array>
#include <limits>
#include <utility>

namespace lumenfarm::testing {

namespace {

constexpr double tick_s = 0.2;
constexpr std::uint64_t fingerprint = 7;
const std::filesystem::path storage_folder = "/storage";

}  // namespace

SimulatedMaster::SimulatedMaster(World& world, FarmChecks& checks, std::uint64_t seed,
                                 const MasterConditions& conditions)
    : world_(world),
      checks_(checks),
      conditions_(conditions),
      disk_(seed),
      vfs_(disk_, static_cast<int>(seed)),
      snapshot_rule_{.times_sums = std::array<std::uint64_t, 8>{0, 1, 0, 1, 0, 1, 0, 8}[seed / 4 % 8]} {
    start();
    disk_failures_ = conditions.disk_failures;
    disk_.fail_sometimes({0, disk_failures_, disk_failures_});
}

/// Tries until the disk gives what it has: the power may fail while the master starts, too.
void SimulatedMaster::start() {
    while (checks_.violations().empty()) {
        auto storage = Storage::open(disk_, storage_folder, vfs_.name(), snapshot_rule_);
        auto start = storage ? (*storage)->start() : Result<Storage::Start>(storage.error());
        ++lives_;
        if (start) return begin_life(std::move(*storage), std::move(*start));
        if (disk_.has_power() && start.error().code != ErrorCode::no_space && disk_failures_ == 0)
            checks_.violated("the master does not start: " + start.error().sentence);
        disk_.power_off();
        if (storage) storage->reset();
        disk_.crash(world_.chance.engine());
        disk_.set_capacity(std::numeric_limits<std::uint64_t>::max());
    }
}

void SimulatedMaster::begin_life(std::unique_ptr<Storage> storage, Storage::Start start) {
    world_.note(Who::master, lives_, "starts, in epoch", {start.life});
    checks_.on_master_start(start);
    storage_ = std::move(storage);
    MasterPolicy policy;
    policy.fingerprint = fingerprint;
    policy.epoch = start.life;
    policy.first_job = start.next_job;
    policy.checkpoint_seconds = conditions_.checkpoint_seconds;
    policy.recut_above = 1.25;
    policy.recut_seconds = conditions_.recut_seconds;
    policy.recut_hits = 200;
    policy.audit_fraction = conditions_.audit_fraction;
    policy.audit_key = world_.chance.number(0, std::numeric_limits<std::uint64_t>::max());
    core_ = std::make_unique<MasterCore>(policy);
    commits_ = {};
    storage_free_s_ = up_since_s_ = world_.now_s();
    for (JobRecord& record : start.records) core_->restore(std::move(record));
    world_.network.listen(this);
    tick();
}

void SimulatedMaster::end(bool machine_too) {
    if (!core_) return;
    world_.note(Who::master, lives_, machine_too ? "loses its power" : "is killed");
    world_.network.listen(nullptr);
    for (const auto& [id, hello] : std::exchange(sessions_, {}))
        machine_too ? world_.network.vanish(id, Side::master) : world_.network.kill(id, Side::master);
    core_.reset();
    disk_.power_off();
    storage_.reset();
    disk_.crash(world_.chance.engine());
    checks_.on_master_end();
    world_.clock.after(world_.chance.exponential(conditions_.down_s), [this] { start(); });
}

void SimulatedMaster::fill_disk(double seconds) {
    world_.note(Who::disk, 0, "is full, for milliseconds", {static_cast<std::uint64_t>(seconds * 1000)});
    disk_free_ = false;
    disk_.set_capacity(disk_.used() + world_.chance.number(0, 20'000));
    world_.clock.after(seconds, [this] {
        disk_free_ = true;
        disk_.set_capacity(std::numeric_limits<std::uint64_t>::max());
    });
}

void SimulatedMaster::calm_disk() {
    disk_failures_ = 0;
    disk_.fail_sometimes({});
}

void SimulatedMaster::tick() {
    world_.clock.after(tick_s, [this, life = lives_] {
        if (!core_ || life != lives_) return;
        tick();
        checks_.before_tick(*core_);
        Effects effects = core_->tick(world_.now_s());
        checks_.after_tick(*core_);
        carry_out(std::move(effects));
        commit(true);
    });
}

// The network

void SimulatedMaster::on_open(ConnectionId connection) {
    sessions_[connection];
    carry_out(core_->on_connect(connection, "10.0.0.1:1", world_.now_s()));
}

void SimulatedMaster::on_message(ConnectionId connection, wire::Message message, std::uint64_t request_id) {
    if (const auto* hello = std::get_if<wire::Hello>(&message)) sessions_[connection] = *hello;
    if (std::holds_alternative<wire::Progress>(message)) checks_.on_leases_stated(sessions_[connection].instance);
    if (const auto* control = std::get_if<wire::ControlRequest>(&message))
        if (control->action == wire::JobAction::extend) checks_.on_extension_asked(control->job);
    carry_out(core_->on_message(connection, std::move(message), request_id, world_.now_s()));
}

void SimulatedMaster::on_close(ConnectionId connection, const std::optional<wire::Goodbye>&) {
    checks_.on_worker_left(sessions_[connection].instance);
    sessions_.erase(connection);
    carry_out(core_->on_disconnect(connection, world_.now_s()));
}

// The core's effects

void SimulatedMaster::carry_out(Effects effects) {
    for (Effect& effect : effects) std::visit([&](auto& each) { carry_out(each); }, effect);
}

void SimulatedMaster::carry_out(Send& send) {
    const auto session = sessions_.find(send.session);
    if (session == sessions_.end()) return;
    if (const auto* goodbye = std::get_if<wire::Goodbye>(&send.message))
        return world_.network.close(send.session, Side::master, *goodbye);
    checks_.on_sent(*core_, session->second.instance, send.message);
    world_.network.send(send.session, Side::master, std::move(send.message), send.request_id);
}

void SimulatedMaster::carry_out(Close& close) {
    const auto session = sessions_.find(close.session);
    if (session == sessions_.end()) return;
    checks_.on_worker_left(session->second.instance);
    sessions_.erase(session);
    world_.network.close(close.session, Side::master, wire::Goodbye(wire::GoodbyeReason::done));
}

template <class Work, class Then>
void SimulatedMaster::slowly(Work work, Then then) {
    storage_free_s_ = std::max(storage_free_s_, world_.now_s()) + world_.chance.uniform(0.001, 0.1);
    world_.clock.at(storage_free_s_, [this, work, then, life = lives_] {
        if (!core_ || life != lives_) return;
        auto result = work();
        if (storage_->broken()) return end(true);
        carry_out(then(std::move(result)));
    });
}

void SimulatedMaster::carry_out(Admit& admit) {
    slowly([this, admit] { return storage_->admit(admit); },
           [this, admit](const Result<std::vector<std::uint32_t>>& missing) {
               return core_->on_admitted(admit, missing, world_.now_s());
           });
}

void SimulatedMaster::carry_out(StoreChunk& store) {
    slowly([this, chunk = std::move(store.chunk)] { return storage_->put_chunk(chunk); },
           [](const Result<void>&) { return Effects{}; });
}

void SimulatedMaster::carry_out(ServeManifest& serve) {
    slowly([this, serve] { return storage_->serve(serve); },
           [serve](wire::Message reply) {
               return Effects{Send{serve.session, std::move(reply), serve.request_id}};
           });
}

void SimulatedMaster::carry_out(ServeChunk& serve) {
    slowly([this, serve] { return storage_->serve(serve); },
           [this, serve](wire::Message reply) {
               auto* chunk = std::get_if<wire::Chunk>(&reply);
               last_chunk_was_bad_ = chunk && !last_chunk_was_bad_ && world_.chance.happens(conditions_.bad_chunks);
               if (last_chunk_was_bad_) chunk->bytes[chunk->bytes.size() / 2] ^= std::byte{1};
               return Effects{Send{serve.session, std::move(reply), serve.request_id}};
           });
}

void SimulatedMaster::carry_out(Prepare& prepare) {
    slowly([this, prepare] { return storage_->prepare(prepare); },
           [this, job = prepare.job](Result<RecoveredJob> recovered) {
               if (recovered) checks_.on_recovered(job, *recovered);
               return core_->on_prepared(job.id(), std::move(recovered), world_.now_s());
           });
}

void SimulatedMaster::carry_out(MeasureCut& measure) {
    slowly([this, measure] { return storage_->measure(measure); },
           [this, measure](const Evenness& evenness) {
               return core_->on_cut_measured(measure, evenness, world_.now_s());
           });
}

void SimulatedMaster::carry_out(StoreResult& store) {
    commits_.add(std::move(store));
    commit(false);
}

void SimulatedMaster::commit(bool leases_too) {
    const auto batch = commits_.begin(leases_too);
    if (!batch) return;
    slowly([this, batch] { return storage_->commit(*batch); },
           [this, batch](const Result<std::map<JobId, Merged>>& stored) {
               commits_.end(*batch, stored.has_value());
               Effects effects = core_->on_results_stored(batch->tickets(), stored, world_.now_s());
               commit(false);
               return effects;
           });
}

void SimulatedMaster::carry_out(StoreSnapshot& store) {
    slowly([this, store] { return storage_->store(store); },
           [this, store](const Result<bool>& stored) {
               if (stored && *stored && !store.last) ++snapshots_;
               return core_->on_snapshot_stored(store, world_.now_s());
           });
}

void SimulatedMaster::carry_out(StoreRecord& store) {
    slowly(
        [this, store] { return storage_->put(store); },
        [this, store](const Result<void>& stored) { return core_->on_record_stored(store, stored, world_.now_s()); });
}

void SimulatedMaster::carry_out(Retract& retract) {
    slowly([this, retract] { return storage_->retract(retract); },
           [this, retract](Result<Retracted> left) {
               if (left) checks_.on_retracted(retract, *left);
               return core_->on_retracted(retract, std::move(left), world_.now_s());
           });
}

void SimulatedMaster::carry_out(PutAside& aside) {
    slowly([this, aside] { return storage_->put_aside(aside); },
           [this, aside](const Result<void>&) { return core_->on_put_aside(aside, world_.now_s()); });
}

void SimulatedMaster::carry_out(RemoveJob& remove) {
    slowly([this, remove] { return storage_->remove(remove); },
           [this, remove](const Result<void>& removed) { return core_->on_removed(remove, removed, world_.now_s()); });
}

void SimulatedMaster::carry_out(StoreSolution& store) {
    slowly([this, store] { return storage_->store(store); },
           [this, store](const Result<JobRecord>& stored) {
               return core_->on_solution_stored(store, stored, world_.now_s());
           });
}

}  // namespace lumenfarm::testing
