#include "tests/simulation/simulated_worker.h"

#include "common/net/connector.h"
#include "common/scene/scene_file.h"
#include "common/support/ensure.h"
#include "tests/simulation/lying_tracer.h"

#include <utility>

namespace lumenfarm::testing {

namespace {

constexpr double tick_s = 0.1;
constexpr std::uint64_t fingerprint = 7;

}  // namespace

void SimulatedWorker::start(WorkerId instance, double slice_s) {
    ensure(!core_, "one process at a time");
    ++life_;
    instance_ = instance;
    slice_s_ = slice_s;
    attempts_ = 0;
    sessions_ = files_missed_ = files_asked_ = 0;
    world_.note(Who::worker, index_, "starts as instance", {instance});
    worker::WorkerIdentity identity;
    identity.name = "worker " + std::to_string(index_);
    identity.instance = instance;
    identity.threads = threads_;
    identity.fingerprint = fingerprint;
    identity.memory_bytes = memory_bytes_;
    identity.parts_only = parts_only_;
    core_ = std::make_unique<worker::WorkerCore>(identity);
    slots_.clear();
    slots_.resize(threads_);
    for (SlotRun& slot : slots_) {
        // each look at the clock is a microsecond of work
        const auto cpu_s = [looks = 0]() mutable { return 1e-6 * ++looks; };
        slot.slot = std::make_unique<TraceSlot>(SlotClocks{[this] { return world_.now_s(); }, cpu_s});
    }
    connection_ = network_.connect(host(), *this);
    tick();
}

void SimulatedWorker::end(bool machine_too) {
    if (!core_) return;
    world_.note(Who::worker, index_, machine_too ? "loses its power" : "is killed");
    machine_too ? network_.vanish(connection_, Side::peer) : network_.kill(connection_, Side::peer);
    connection_ = 0;
    ++life_;
    core_.reset();
}

void SimulatedWorker::later(double delay_s, std::function<void()> event) {
    world_.clock.after(delay_s, [this, life = life_, event = std::move(event)] {
        if (life == life_) event();
    });
}

void SimulatedWorker::tick() {
    later(tick_s, [this] {
        tick();
        carry_out(core_->tick(world_.now_s()));
    });
}

// The network

void SimulatedWorker::on_open(ConnectionId) { carry_out(core_->on_connect(world_.now_s())); }

void SimulatedWorker::on_message(ConnectionId, wire::Message message, std::uint64_t) {
    if (std::holds_alternative<wire::Welcome>(message)) {
        attempts_ = 0;
        ++sessions_;
    }
    carry_out(core_->on_message(std::move(message), world_.now_s()));
}

void SimulatedWorker::on_close(ConnectionId, const std::optional<wire::Goodbye>& goodbye) {
    connection_ = 0;
    connect_later();
    carry_out(core_->on_disconnect(goodbye, world_.now_s()));
}

void SimulatedWorker::connect_later() {
    later(net::reconnect_delay_seconds(attempts_++, world_.chance.uniform(0, 1)),
          [this] { connection_ = network_.connect(host(), *this); });
}

void SimulatedWorker::send(wire::Message message) {
    if (const auto* done = std::get_if<wire::ResultDone>(&message)) checks_.on_offer(instance_, *done);
    if (std::holds_alternative<wire::ManifestRequest>(message))
        checks_.on_files_asked(++files_asked_, sessions_ + files_missed_);
    network_.send(connection_, Side::peer, std::move(message));
}

// The core's effects

void SimulatedWorker::carry_out(worker::Effects effects) {
    const std::uint64_t life = life_;
    for (worker::Effect& effect : effects) std::visit([&](auto& each) { carry_out(each); }, effect);
    while (life == life_ && connection_ != 0 && !network_.congested(connection_, Side::peer)) {
        auto part = core_->next_bulk();
        if (!part) return;
        send(std::move(*part));
    }
}

void SimulatedWorker::carry_out(worker::Send& effect) { send(std::move(effect.message)); }

void SimulatedWorker::slice(std::size_t index, SlotAsk ask) {
    later(ask == SlotAsk::nothing ? slice_s_ : 0.001, [this, index, ask] {
        SlotRun& run = slots_[index];
        if (auto report = run.slot->advance(ask)) {
            run.busy = false;
            return carry_out(core_->on_slot(index, std::move(*report), world_.now_s()));
        }
        slice(index, std::exchange(run.interrupt, SlotAsk::nothing));
    });
}

void SimulatedWorker::obey(std::size_t slot, SlotAsk ask) {
    ensure(!slots_[slot].busy, "a slot has one command at a time");
    slots_[slot].busy = true;
    slots_[slot].interrupt = SlotAsk::nothing;
    slice(slot, ask);
}

void SimulatedWorker::carry_out(worker::StartSlot& start) {
    slots_[start.slot].slot->begin(std::move(start.work));
    obey(start.slot, SlotAsk::nothing);
}

void SimulatedWorker::carry_out(worker::InterruptSlot& interrupt) {
    SlotRun& run = slots_[interrupt.slot];
    if (run.busy && run.interrupt != SlotAsk::abandon) run.interrupt = interrupt.ask;
}

void SimulatedWorker::carry_out(worker::LoadScene& load) {
    later(0.01, [this, scene = load.scene] {
        const auto kept = cache_.find(scene);
        files_missed_ += kept == cache_.end();
        carry_out(core_->on_scene_loaded(scene, kept == cache_.end() ? nullptr : kept->second, world_.now_s()));
    });
}

void SimulatedWorker::carry_out(worker::PrepareJob& prepare) {
    if (prepare.info.spec.strategy == Strategy::subspaces)
        return later(0.1, [this, prepare] {
            auto plan = make_plan_context(*prepare.scene_bytes).value();
            carry_out(core_->on_job_prepared(prepare.info, make_job_context(prepare.info, nullptr, std::move(plan)),
                                             world_.now_s()));
        });
    auto scene = std::make_shared<SceneContext>();
    scene->scene = decode_scene(*prepare.scene_bytes).value();
    if (lies_one_in_ > 0) {
        scene->tracer = std::make_unique<LyingTracer>(scene->scene, lies_one_in_);
    } else {
        scene->tracer = std::make_unique<FakeTracer>(scene->scene);
    }
    later(0.1, [this, info = prepare.info, scene] {
        carry_out(core_->on_job_prepared(info, make_job_context(info, scene, nullptr), world_.now_s()));
    });
}

void SimulatedWorker::carry_out(worker::PreparePart& prepare) {
    later(0.1, [this, prepare] {
        auto piece = make_piece(prepare.key.subspace, *prepare.part_bytes, prepare.job->plan, {});
        carry_out(core_->on_part_prepared(prepare.key, prepare.file, std::move(piece), world_.now_s()));
    });
}

void SimulatedWorker::carry_out(worker::Finished&) {
    world_.note(Who::worker, index_, "has nothing left to do");
    network_.close(connection_, Side::peer, wire::Goodbye(wire::GoodbyeReason::done));
    connection_ = 0;
    drained_ = true;
    ++life_;
}

void SimulatedWorker::carry_out(worker::GiveUp& give_up) {
    world_.note(Who::worker, index_, "gives up");
    if (lies_one_in_ == 0) checks_.violated("a worker gives up: " + give_up.sentence);
    drained_ = true;
    ++life_;
}

}  // namespace lumenfarm::testing
