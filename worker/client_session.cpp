#include "worker/client_session.h"

#include <spdlog/spdlog.h>
#include <boost/asio/post.hpp>

#include <utility>

namespace lumenfarm {

namespace asio = boost::asio;

namespace {

constexpr auto tick_interval = std::chrono::milliseconds(100);

}  // namespace

WorkerClient::Running::Running(const WorkerOptions& options, const net::HostPort& master,
                               const worker::WorkerIdentity& identity)
    : isa_(options.isa),
      make_job_(options.make_job ? options.make_job : tracing_jobs(options.isa)),
      cache_(options.cache.empty() ? worker::default_cache_folder() : options.cache, options.cache_bytes_max),
      core_(identity, options.drain_seconds),
      master_(io_, master, identity.instance, *this) {
    for (std::uint32_t i = 0; i < identity.threads; ++i) {
        const auto on_report = [this, i](SlotReport report) {
            auto shared = std::make_shared<SlotReport>(std::move(report));
            asio::post(io_, [this, i, shared] { carry_out(core_.on_slot(i, std::move(*shared), now_s())); });
        };
        slots_.push_back(options.make_slot ? options.make_slot(io_, on_report)
                                           : std::make_unique<worker::SlotThread>(options.idle_priority, on_report));
    }
    asio::post(io_, [this] {
        master_.connect();
        tick();
    });
    thread_ = std::thread([this] {
        io_.run();
        {
            const std::lock_guard lock(mutex_);
            ended_ = true;
        }
        ended_changed_.notify_all();
    });
}

WorkerClient::Running::~Running() {
    asio::post(io_, [this] { end(std::nullopt); });
    thread_.join();
    slots_.clear();
    scene_thread_.join();
}

double WorkerClient::Running::now_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void WorkerClient::Running::drain() {
    asio::post(io_, [this] { carry_out(core_.drain(now_s())); });
}

void WorkerClient::Running::end_now() {
    asio::post(io_, [this] { carry_out(core_.end_now(now_s())); });
}

Result<void> WorkerClient::Running::wait() {
    std::unique_lock lock(mutex_);
    ended_changed_.wait(lock, [this] { return ended_; });
    if (error_) return *error_;
    return {};
}

bool WorkerClient::Running::ended() const {
    const std::lock_guard lock(mutex_);
    return ended_;
}

std::string WorkerClient::Running::summary() const {
    const std::lock_guard lock(mutex_);
    return summary_;
}

std::vector<ServingThread> WorkerClient::Running::threads() {
    const auto in_turn = [](auto& thread) {
        return [&thread](ServingThread::Answer answer) { asio::post(thread, std::move(answer)); };
    };
    std::vector<ServingThread> all{{"the loop", in_turn(io_), 0},
                                   {"the scene's thread", in_turn(scene_thread_), limits::busy_seconds_max}};
    for (std::size_t i = 0; i < slots_.size(); ++i)
        all.push_back({"tracing thread " + std::to_string(i + 1),
                       [&slot = *slots_[i]](ServingThread::Answer answer) { slot.ask(std::move(answer)); },
                       limits::busy_seconds_max});
    return all;
}

/// The threads may still be tracing their last slice; nobody waits for what they find.
void WorkerClient::Running::end(std::optional<Error> error) {
    if (std::exchange(ending_, true)) return;
    if (const std::string counts = core_.counts().text(); !counts.empty()) spdlog::info("{}", counts);
    tick_timer_.cancel();
    {
        const std::lock_guard lock(mutex_);
        error_ = std::move(error);
    }
    master_.finish(wire::Goodbye(wire::GoodbyeReason::done, "the worker ends"));
}

void WorkerClient::Running::tick() {
    carry_out(core_.tick(now_s()));
    {
        std::string line = master_.welcome() ? "connected to " : "waits for the master at ";
        line += master_.master().text() + "; " + core_.summary();
        const std::lock_guard lock(mutex_);
        summary_ = std::move(line);
    }
    tick_timer_.expires_after(tick_interval);
    tick_timer_.async_wait([this](const boost::system::error_code& error) {
        if (!error && !ending_) tick();
    });
}

void WorkerClient::Running::on_master_open() { carry_out(core_.on_connect(now_s())); }

void WorkerClient::Running::on_master_message(wire::Message message) {
    carry_out(core_.on_message(std::move(message), now_s()));
}

void WorkerClient::Running::on_master_lost(const net::Closed& closed) {
    core_.counts().count(closed);
    carry_out(core_.on_disconnect(closed.goodbye, now_s()));
}

void WorkerClient::Running::on_master_finished(const std::optional<net::Closed>& closed) {
    if (closed) core_.counts().count(*closed);
    io_.stop();
}

void WorkerClient::Running::carry_out(worker::Effects effects) {
    for (worker::Effect& effect : effects) std::visit([&](auto& each) { carry_out(each); }, effect);
    merged_ = core_.particles_merged();
    master_.pump();
}

void WorkerClient::Running::carry_out(const worker::Send& send) { master_.send(send.message); }

void WorkerClient::Running::carry_out(const worker::LoadScene& load) {
    asio::post(scene_thread_, [this, scene = load.scene] {
        const auto loaded = cache_.load(scene);
        if (!loaded) discard(worker::Discard::cached_scene_damaged, loaded.error().sentence);
        asio::post(io_, [this, scene, bytes = loaded ? *loaded : nullptr] {
            carry_out(core_.on_scene_loaded(scene, bytes, now_s()));
        });
    });
}

void WorkerClient::Running::carry_out(const worker::KeepScene& keep) {
    asio::post(scene_thread_, [this, keep] {
        const auto kept = cache_.keep(keep.scene, *keep.bytes);
        if (!kept) return discard(worker::Discard::scene_not_cached, kept.error().sentence);
        for (const Digest& displaced : *kept) discard(worker::Discard::cached_scene_displaced, displaced.hex());
    });
}

void WorkerClient::Running::carry_out(const worker::Discarded& discarded) {
    spdlog::info("{} {}: {}", name_of(discarded.reason), discarded.times, discarded.sentence);
}

/// From any thread.
void WorkerClient::Running::discard(worker::Discard reason, std::string sentence) {
    asio::post(io_, [this, reason, sentence = std::move(sentence)] {
        carry_out(core_.on_discarded(reason, sentence, now_s()));
    });
}

void WorkerClient::Running::carry_out(const worker::PrepareJob& effect) {
    asio::post(scene_thread_, [this, effect] {
        auto prepared = make_job_(effect.info, *effect.scene_bytes);
        if (!prepared) spdlog::error("job {} can't be traced here: {}", effect.info.job, prepared.error().sentence);
        asio::post(io_, [this, info = effect.info, prepared = std::move(prepared)]() mutable {
            carry_out(core_.on_job_prepared(info, std::move(prepared), now_s()));
        });
    });
}

void WorkerClient::Running::carry_out(const worker::PreparePart& effect) {
    asio::post(scene_thread_, [this, effect] {
        auto prepared = make_piece(effect.key.subspace, *effect.part_bytes, effect.job->plan, isa_);
        if (!prepared) spdlog::error("{} can't be traced here: {}", effect.key.text(), prepared.error().sentence);
        asio::post(io_, [this, effect, prepared = std::move(prepared)]() mutable {
            carry_out(core_.on_part_prepared(effect.key, effect.file, std::move(prepared), now_s()));
        });
    });
}

void WorkerClient::Running::carry_out(const worker::Finished&) { end(std::nullopt); }
void WorkerClient::Running::carry_out(const worker::GiveUp& give_up) { end(failed(give_up.sentence)); }

}  // namespace lumenfarm
