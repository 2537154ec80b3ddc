#include "tests/simulation/farm.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::testing {

namespace {

constexpr double absurd_s = 50'000;
constexpr JobId the_job = 1;
constexpr double sleep_s = 40'000;

MasterPolicy policy_of_life(std::uint64_t life) {
    MasterPolicy policy;
    policy.fingerprint = 7;
    policy.epoch = static_cast<std::uint32_t>(life);
    return policy;
}

}  // namespace

Farm::Farm(const JobSpec& spec, const FarmOptions& options)
    : spec_(spec), options_(options), random_(options.seed), scene_bytes_(encode_scene(small_scene())) {
    master_ = std::make_unique<MasterCore>(policy_of_life(++master_life_));
    nodes_.resize(options.workers);
    const wire::FileManifest manifest(scene_digest(scene_bytes_), scene_bytes_.size(), chunk_digests(scene_bytes_));
    at(0, [this, manifest] {
        carry_out(master_->on_message(embedding_session, wire::Submit(9, spec_, manifest), 1, now_s_));
    });
    for (std::size_t i = 0; i < nodes_.size(); ++i) at(uniform(0, 1), [this, i] { start_worker(i); });
    repeat(0, [this] { carry_out(master_->tick(now_s_)); });
    const auto any = [this] { return std::uniform_int_distribution<std::size_t>(0, nodes_.size() - 1)(random_); };
    if (options.seconds_between_drops > 0) repeat(options.seconds_between_drops, [this, any] { drop(any()); });
    if (options.seconds_between_crashes > 0)
        repeat(options.seconds_between_crashes, [this, any] {
            const std::size_t index = any();
            drop(index);
            start_worker(index);
        });
    if (options.seconds_between_master_crashes > 0)
        repeat(options.seconds_between_master_crashes, [this] { master_crash(); });
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
        if (now != wire::JobState::queued && now != wire::JobState::running) return true;
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
    identity.instance = next_instance_++;
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
    at(now_s_ + uniform(0.5, 15), [this, index, life] {
        if (nodes_[index].life == life && nodes_[index].session == 0) connect(index);
    });
}

void Farm::master_crash() {
    if (!record_) return;
    master_ = std::make_unique<MasterCore>(policy_of_life(++master_life_));
    carry_out(master_->restore(*record_));
    for (std::size_t i = 0; i < nodes_.size(); ++i) drop(i);
}

// The master's effects

void Farm::carry_out(Effects effects) {
    for (Effect& effect : effects) std::visit([&](auto& each) { carry_out(each); }, effect);
}

void Farm::carry_out(Send& send) { to_worker(send.session, std::move(send.message)); }

void Farm::to_worker(SessionId session, wire::Message message) {
    const auto found = sessions_.find(session);
    if (found == sessions_.end()) return;
    Node& node = nodes_[found->second];
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

void Farm::carry_out(Admit& admit) {
    record_ = admit.record;
    at(now_s_ + 0.1, [this, admit, life = master_life_] {
        if (life == master_life_) carry_out(master_->on_admitted(admit, std::vector<std::uint32_t>{}, now_s_));
    });
}

void Farm::carry_out(Prepare& prepare) {
    at(now_s_ + 0.1, [this, prepare, life = master_life_] {
        if (life == master_life_)
            carry_out(master_->on_prepared(prepare.job, prepare_job(prepare.spec, scene_bytes_), now_s_));
    });
}

void Farm::carry_out(StoreSolution& store) {
    at(now_s_ + uniform(0.01, 1), [this, store, life = master_life_] {
        if (life != master_life_) return;
        solution_ = store.solution;
        ++solutions_;
        carry_out(master_->on_solution_stored(store.job, StoredSolution{solution_digest(*store.solution), {}}, now_s_));
    });
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
