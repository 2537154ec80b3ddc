#include "tests/simulation/farm.h"

#include "common/solution/solution_file.h"
#include "common/support/ensure.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lumenfarm::testing {

namespace {

constexpr double absurd_s = 50'000;
constexpr JobId the_job = 1;
constexpr double sleep_s = 40'000;

const std::filesystem::path storage_folder = "/storage";

}  // namespace

Farm::Farm(const JobSpec& spec, const FarmOptions& options)
    : spec_(spec),
      options_(options),
      random_(options.seed),
      scene_bytes_(encode_scene(small_scene())),
      disk_(options.seed),
      vfs_(disk_, static_cast<int>(options.seed)) {
    start_master();
    disk_.fail_sometimes({0, options.disk_failures, options.disk_failures});
    nodes_.resize(options.workers);
    at(0, [this] { submit(); });
    for (std::size_t i = 0; i < nodes_.size(); ++i)
        at(uniform(0, 1), [this, i] {
            if (nodes_[i].life == 0) start_worker(i);
        });
    repeat(0, [this] {
        carry_out(master_->tick(now_s_));
        commit(true);
    });
    const auto any = [this] { return std::uniform_int_distribution<std::size_t>(0, nodes_.size() - 1)(random_); };
    if (options.seconds_between_drops > 0) repeat(options.seconds_between_drops, [this, any] { drop(any()); });
    if (options.seconds_between_crashes > 0)
        repeat(options.seconds_between_crashes, [this, any] {
            const std::size_t index = any();
            drop(index);
            start_worker(index);
        });
    if (options.seconds_between_power_cuts > 0)
        repeat(options.seconds_between_power_cuts, [this] {
            // most often in the midst of something
            if (uniform(0, 1) < 0.2) return cut_power();
            disk_.crash_at(std::uniform_int_distribution<std::uint64_t>(1, 12)(random_));
        });
    if (options.seconds_between_full_disks > 0) repeat(options.seconds_between_full_disks, [this] { fill_disk(); });
}

/// Tries until the disk gives what it has: the power may fail while the master starts, too.
void Farm::start_master() {
    while (violations_.empty()) {
        ++master_life_;
        auto storage = Storage::open(disk_, storage_folder, vfs_.name());
        auto start = storage ? (*storage)->start() : Result<Storage::Start>(storage.error());
        if (start) return begin_life(std::move(*storage), std::move(*start));
        if (disk_.has_power() && start.error().code != ErrorCode::no_space && options_.disk_failures == 0)
            violations_.push_back("the master does not start: " + start.error().sentence);
        disk_.power_off();
        if (storage) storage->reset();
        disk_.crash(random_);
        disk_.set_capacity(std::numeric_limits<std::uint64_t>::max());
    }
}

void Farm::begin_life(std::unique_ptr<Storage> storage, Storage::Start start) {
    for (const std::string& warning : start.warnings) violations_.push_back(warning);
    storage_ = std::move(storage);
    MasterPolicy policy;
    policy.fingerprint = 7;
    policy.epoch = start.life;
    policy.first_job = start.next_job;
    policy.checkpoint_seconds = options_.checkpoint_seconds;
    master_ = std::make_unique<MasterCore>(policy);
    commits_ = {};
    storage_free_s_ = now_s_;
    for (JobRecord& record : start.records) master_->restore(std::move(record));
}

void Farm::cut_power() {
    disk_.power_off();
    storage_.reset();
    disk_.crash(random_);
    start_master();
    for (std::size_t i = 0; i < nodes_.size(); ++i) drop(i);
    if (!submitted_) at(now_s_ + 1, [this] { submit(); });
}

/// The client asks again until it has its answer.
void Farm::submit() {
    if (submitted_) return;
    const wire::FileManifest manifest(scene_digest(scene_bytes_), scene_bytes_.size(), chunk_digests(scene_bytes_));
    (void)storage_->put_scene(scene_bytes_);
    if (storage_->broken()) return cut_power();
    carry_out(master_->on_message(embedding_session, wire::Submit(9, spec_, manifest), 1, now_s_));
}

void Farm::fill_disk() {
    disk_.set_capacity(disk_.used() + std::uniform_int_distribution<std::uint64_t>(0, 20'000)(random_));
    at(now_s_ + uniform(0.5, 15), [this] { disk_.set_capacity(std::numeric_limits<std::uint64_t>::max()); });
}

void Farm::at(double time_s, std::function<void()> event) { events_.push({time_s, ++events_made_, std::move(event)}); }

/// Again and again, at random times; mean 0: every 0.2 s.
void Farm::repeat(double mean_s, std::function<void()> event) {
    const double delay_s = mean_s > 0 ? exponential(mean_s) : 0.2;
    at(now_s_ + delay_s, [this, mean_s, event] {
        event();
        repeat(mean_s, event);
    });
}

wire::JobState Farm::state() const {
    const auto status = master_->status(the_job, now_s_);
    return status ? status->state : wire::JobState::queued;
}

bool Farm::run() {
    while (now_s_ < absurd_s) {
        const wire::JobState now = state();
        if (wire::is_over(now)) return true;
        if (!violations_.empty()) return false;
        // sets that were lost thrice by chance: somebody looks, and tries them again
        if (now == wire::JobState::paused)
            carry_out(master_->on_message(embedding_session, wire::ControlRequest(the_job, wire::JobAction::resume), 2,
                                          now_s_));
        Event next = events_.top();
        events_.pop();
        now_s_ = next.time_s;
        next.run();
    }
    return false;
}

void Farm::cancel() { carry_out(master_->cancel(the_job, now_s_)); }
void Farm::drain_worker(std::size_t index) { carry_out(index, nodes_[index].core->drain(now_s_)); }

void Farm::start_worker(std::size_t index) {
    Node& node = nodes_[index];
    const std::uint64_t life = node.life + 1;
    node = Node{};
    node.life = life;
    node.slice_s = options_.one_worker_sleeps && index == 0 ? sleep_s : uniform(0.01, 0.2);
    worker::WorkerIdentity identity;
    identity.name = "worker " + std::to_string(index);
    identity.instance = node.instance = next_instance_++;
    identity.threads = options_.threads;
    identity.fingerprint = 7;
    node.core = std::make_unique<worker::WorkerCore>(identity);
    node.slots.resize(options_.threads);
    for (SlotRun& slot : node.slots)
        slot.slot = std::make_unique<TraceSlot>(SlotClocks{[this] { return now_s_; }, [] { return 0.0; }});
    connect(index);
    beat(index, life);
    later(index, 0.1, [](worker::WorkerCore&) { return worker::Effects{}; });
}

/// Ticks of the worker, and heartbeats that its connection sends for it.
void Farm::beat(std::size_t index, std::uint64_t life) {
    at(now_s_ + 0.1, [this, index, life] {
        Node& node = nodes_[index];
        if (node.life != life || node.over) return;
        if (node.session != 0) carry_out(master_->on_message(node.session, wire::Heartbeat(1), 0, now_s_));
        carry_out(index, node.core->tick(now_s_));
        beat(index, life);
    });
}

void Farm::connect(std::size_t index) {
    Node& node = nodes_[index];
    if (node.over) return;
    node.session = next_session_++;
    sessions_[node.session] = index;
    carry_out(master_->on_connect(node.session, "10.0.0.1:1", now_s_));
    carry_out(index, node.core->on_connect(now_s_));
}

/// Both ends learn of it; what was on its way is lost.
void Farm::drop(std::size_t index) {
    Node& node = nodes_[index];
    if (node.session == 0) return;
    const SessionId session = std::exchange(node.session, 0);
    sessions_.erase(session);
    carry_out(master_->on_disconnect(session, now_s_));
    carry_out(index, node.core->on_disconnect(std::nullopt, now_s_));
    const std::uint64_t life = node.life;
    at(now_s_ + std::min(0.2 + exponential(2), 15.0), [this, index, life] {
        if (nodes_[index].life == life && nodes_[index].session == 0) connect(index);
    });
}

// The master's effects

void Farm::carry_out(Effects effects) {
    for (Effect& effect : effects) std::visit([&](auto& each) { carry_out(each); }, effect);
}

void Farm::carry_out(Send& send) {
    if (send.session != embedding_session) return to_worker(send.session, std::move(send.message));
    const auto* reply = std::get_if<wire::SubmitReply>(&send.message);
    submitted_ = submitted_ || (reply && reply->job != 0);
    if (!submitted_) at(now_s_ + 1, [this] { submit(); });
}

void Farm::to_worker(SessionId session, wire::Message message) {
    const auto found = sessions_.find(session);
    if (found == sessions_.end()) return;
    Node& node = nodes_[found->second];
    if (const auto* ack = std::get_if<wire::ResultAck>(&message)) note_answer(node.instance, *ack);
    node.last_to_worker_s = std::max(node.last_to_worker_s, now_s_ + uniform(0.001, 0.05));
    auto shared = std::make_shared<wire::Message>(std::move(message));
    at(node.last_to_worker_s, [this, index = found->second, session, shared] {
        Node& to = nodes_[index];
        if (to.session == session) carry_out(index, to.core->on_message(std::move(*shared), now_s_));
    });
}

void Farm::carry_out(Close& close) {
    const auto found = sessions_.find(close.session);
    if (found != sessions_.end()) drop(found->second);
}

template <class Work, class Then>
void Farm::slowly(Work work, Then then) {
    storage_free_s_ = std::max(storage_free_s_, now_s_) + uniform(0.001, 0.1);
    at(storage_free_s_, [this, work, then, life = master_life_] {
        if (life != master_life_) return;
        const auto result = work();
        if (storage_->broken()) return cut_power();
        carry_out(then(result));
    });
}

void Farm::carry_out(Admit& admit) {
    slowly([this, admit] { return storage_->admit(admit); },
           [this, admit](const Result<std::vector<std::uint32_t>>& missing) {
               return master_->on_admitted(admit, missing, now_s_);
           });
}

void Farm::carry_out(Prepare& prepare) {
    slowly([this, prepare] { return storage_->prepare(prepare); },
           [this, job = prepare.job.id()](const Result<RecoveredJob>& recovered) {
               if (recovered) check(*recovered);
               return master_->on_prepared(job, recovered, now_s_);
           });
}

void Farm::carry_out(StoreResult& store) {
    commits_.add(std::move(store));
    commit(false);
}

void Farm::commit(bool leases_too) {
    const auto batch = commits_.begin(leases_too);
    if (!batch) return;
    slowly([this, batch] { return storage_->commit(*batch); },
           [this, batch](const Result<std::map<JobId, std::uint64_t>>& stored) {
               commits_.end(*batch, stored.has_value());
               Effects effects = master_->on_results_stored(batch->tickets(), stored, now_s_);
               commit(false);
               return effects;
           });
}

void Farm::carry_out(StoreSnapshot& store) {
    slowly([this, store] { return storage_->store(store); }, [](const Result<void>&) { return Effects{}; });
}

void Farm::carry_out(StoreRecord& store) {
    slowly([this, store] { return storage_->put(store); },
           [this, store](const Result<void>& stored) { return master_->on_record_stored(store, stored, now_s_); });
}

void Farm::carry_out(Retract& retract) {
    slowly([this, retract] { return storage_->retract(retract); },
           [this, retract](Result<Retracted> left) { return master_->on_retracted(retract, std::move(left), now_s_); });
}

void Farm::carry_out(PutAside& aside) {
    slowly([this, aside] { return storage_->put_aside(aside); },
           [this, aside](const Result<void>&) { return master_->on_put_aside(aside, now_s_); });
}

void Farm::carry_out(RemoveJob& remove) {
    slowly([this, remove] { return storage_->remove(remove); },
           [this, remove](const Result<void>& removed) { return master_->on_removed(remove, removed, now_s_); });
}

void Farm::carry_out(StoreSolution& store) {
    slowly(
        [this, store] { return storage_->store(store); },
        [this, store](const Result<JobRecord>& stored) { return master_->on_solution_stored(store, stored, now_s_); });
}

void Farm::note_answer(WorkerId worker, const wire::ResultAck& ack) {
    if (ack.verdict != wire::Verdict::accepted) return;
    for (const wire::Claim& claim : offers_.at({worker, ack.result})) {
        const ParticleRange& range = claim.range;
        acknowledged_.resize(std::max<std::size_t>(acknowledged_.size(), range.light + 1));
        IntervalSet& light = acknowledged_[range.light];
        for (const auto& gap : light.gaps(range.first, range.first + range.count)) light.insert(gap.begin, gap.end);
    }
}

/// What was acknowledged in earlier lives is there.
void Farm::check(const RecoveredJob& recovered) {
    for (const std::string& damage : recovered.damages) violations_.push_back(damage);
    for (std::size_t light = 0; light < acknowledged_.size(); ++light)
        for (const auto& interval : acknowledged_[light].intervals())
            if (!recovered.committed[light].covers(interval.begin, interval.end))
                violations_.push_back("particles " + std::to_string(interval.begin) + " to " +
                                      std::to_string(interval.end) + " of light " + std::to_string(light) +
                                      " were acknowledged, and are gone");
}

Solution Farm::solution() {
    const JobRecord* record = master_->record(the_job);
    ensure(record && record->has_solution, "the job has ended with a solution");
    const auto bytes = storage_->files().read(record->solution_file).value();
    return decode_solution(bytes, small_scene(), scene_digest(scene_bytes_)).value();
}

void Farm::carry_out(ServeManifest& serve) {
    to_worker(serve.session,
              wire::Manifest(wire::FileManifest(serve.file, scene_bytes_.size(), chunk_digests(scene_bytes_))));
}

void Farm::carry_out(ServeChunk& serve) {
    auto bytes = scene_bytes_;  // one chunk
    if (uniform(0, 1) < 0.1) bytes[bytes.size() / 2] ^= std::byte{1};
    to_worker(serve.session, wire::Chunk(serve.file, serve.index, std::move(bytes)));
}

// The workers' effects

void Farm::carry_out(std::size_t index, worker::Effects effects) {
    for (worker::Effect& effect : effects) std::visit([&](auto& each) { carry_out(index, each); }, effect);
    Node& node = nodes_[index];
    most_results_held_ = std::max<std::uint64_t>(most_results_held_, node.core->results_held());
    while (auto part = node.session != 0 ? node.core->next_bulk() : std::nullopt) to_master(index, std::move(*part));
}

void Farm::later(std::size_t index, double delay_s, std::function<worker::Effects(worker::WorkerCore&)> event) {
    at(now_s_ + delay_s, [this, index, life = nodes_[index].life, event] {
        Node& node = nodes_[index];
        if (node.life == life && !node.over) carry_out(index, event(*node.core));
    });
}

void Farm::carry_out(std::size_t index, worker::Send& send) { to_master(index, std::move(send.message)); }

void Farm::to_master(std::size_t index, wire::Message message) {
    Node& node = nodes_[index];
    if (node.session == 0) return;
    if (const auto* done = std::get_if<wire::ResultDone>(&message))
        offers_[{node.instance, done->result}] = done->claims;
    node.last_to_master_s = std::max(node.last_to_master_s, now_s_ + uniform(0.001, 0.05));
    auto shared = std::make_shared<wire::Message>(std::move(message));
    at(node.last_to_master_s, [this, session = node.session, shared] {
        if (sessions_.contains(session)) carry_out(master_->on_message(session, std::move(*shared), 0, now_s_));
    });
}

void Farm::slice(std::size_t index, std::uint64_t life, std::size_t slot, SlotAsk ask) {
    at(now_s_ + (ask == SlotAsk::nothing ? nodes_[index].slice_s : 0.001), [=, this] {
        Node& node = nodes_[index];
        if (node.life != life) return;
        SlotRun& run = node.slots[slot];
        if (auto report = run.slot->advance(ask)) {
            run.busy = false;
            if (!node.over) carry_out(index, node.core->on_slot(slot, std::move(*report), now_s_));
            return;
        }
        slice(index, life, slot, std::exchange(run.interrupt, SlotAsk::nothing));
    });
}

void Farm::carry_out(std::size_t index, worker::StartSlot& start) {
    SlotRun& run = nodes_[index].slots[start.slot];
    ensure(!run.busy, "a slot has one command at a time");
    run.slot->begin(std::move(start.work));
    run.interrupt = SlotAsk::nothing;
    run.busy = true;
    slice(index, nodes_[index].life, start.slot, SlotAsk::nothing);
}

void Farm::carry_out(std::size_t index, worker::ContinueSlot& effect) {
    SlotRun& run = nodes_[index].slots[effect.slot];
    ensure(!run.busy, "a slot has one command at a time");
    run.busy = true;
    slice(index, nodes_[index].life, effect.slot, SlotAsk::nothing);
}

void Farm::carry_out(std::size_t index, worker::TellSlot& tell) {
    SlotRun& run = nodes_[index].slots[tell.slot];
    ensure(!run.busy, "a slot has one command at a time");
    run.busy = true;
    slice(index, nodes_[index].life, tell.slot, tell.ask);
}

void Farm::carry_out(std::size_t index, worker::InterruptSlot& interrupt) {
    SlotRun& run = nodes_[index].slots[interrupt.slot];
    if (run.busy && run.interrupt != SlotAsk::abandon) run.interrupt = interrupt.ask;
}

void Farm::carry_out(std::size_t index, worker::LoadScene& load) {
    later(index, 0.01, [this, scene = load.scene](worker::WorkerCore& core) {
        return core.on_scene_loaded(scene, nullptr, now_s_);
    });
}

void Farm::carry_out(std::size_t index, worker::PrepareJob& prepare) {
    auto scene = std::make_shared<SceneContext>();
    scene->scene = decode_scene(*prepare.scene_bytes).value();
    scene->tracer = std::make_unique<FakeTracer>(scene->scene);
    later(index, 0.1, [this, info = prepare.info, scene](worker::WorkerCore& core) {
        return core.on_job_prepared(info.job, make_job_context(info, scene), now_s_);
    });
}

void Farm::carry_out(std::size_t index, worker::Finished&) {
    ++finished_;
    nodes_[index].over = true;
    at(now_s_ + 0.5, [this, index] { drop(index); });  // after what was sent has arrived
}

void Farm::carry_out(std::size_t, worker::GiveUp&) { ensure(false, "no worker is refused in these farms"); }

Solution reference_solution(const JobSpec& spec) {
    const auto bytes = encode_scene(small_scene());
    const auto prepared = prepare_job(spec, bytes).value();
    const FakeTracer tracer(prepared->scene);
    LightMap sums(prepared->scene, prepared->layout);
    KeptHits kept(spec.keep_hits);
    Solution solution;
    solution.scene = scene_digest(bytes);
    solution.spec = spec;
    solution.committed.resize(prepared->particles.size());
    for (std::uint32_t light = 0; light < prepared->particles.size(); ++light) {
        TracedHits hits;
        tracer.trace(spec, {light, 0, prepared->particles[light]}, hits, nullptr);
        sums.add(tracer.emission(), light, hits.records, hits.energies);
        for (std::size_t i = 0; i < hits.records.size(); ++i) {
            const std::uint32_t energy = hits.energies.empty()
                                             ? tracer.emission().lights[light].energy[hits.records[i].wavelength]
                                             : hits.energies[i];
            kept.offer({hits.records[i], light, energy});
        }
        solution.balance += hits.balance;
        if (prepared->particles[light] > 0) solution.committed[light].insert(0, prepared->particles[light]);
    }
    solution.texels = sums.texels();
    solution.surfaces = sums.surfaces();
    solution.kept = kept.sorted();
    return solution;
}

}  // namespace lumenfarm::testing
