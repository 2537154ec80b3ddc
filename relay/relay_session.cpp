#include "relay/relay_session.h"

#include "relay/prepare_lent.h"

#include <spdlog/spdlog.h>
#include <boost/asio/post.hpp>

#include <utility>

namespace lumenfarm {

namespace asio = boost::asio;

namespace {

constexpr auto tick_interval = std::chrono::milliseconds(100);

}  // namespace

RelayServer::Running::Running(const RelayOptions& options, const net::HostPort& upstream,
                              const relay::RelayIdentity& identity, const MasterPolicy& farm, StorageLock lock,
                              std::unique_ptr<Disk> disk, std::unique_ptr<FileStore> files)
    : lock_(std::move(lock)),
      disk_(std::move(disk)),
      files_(std::move(files)),
      core_(identity, farm, options.drain_seconds),
      master_(io_, upstream, identity.instance, *this) {}

void RelayServer::Running::run() {
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

RelayServer::Running::~Running() {
    if (!thread_.joinable()) return;
    end_now();
    thread_.join();
    files_thread_.join();
    peers_.detach();
}

double RelayServer::Running::now_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void RelayServer::Running::drain() {
    asio::post(io_, [this] { carry_out(core_.drain(now_s())); });
}

void RelayServer::Running::end_now() {
    asio::post(io_, [this] { carry_out(core_.end_now(now_s())); });
}

bool RelayServer::Running::ended() const {
    const std::lock_guard lock(mutex_);
    return ended_;
}

Result<void> RelayServer::Running::wait() {
    std::unique_lock lock(mutex_);
    ended_changed_.wait(lock, [this] { return ended_; });
    if (error_) return *error_;
    return {};
}

std::string RelayServer::Running::summary() const {
    const std::lock_guard lock(mutex_);
    return summary_;
}

std::vector<ServingThread> RelayServer::Running::threads() {
    const auto in_turn = [](auto& thread) {
        return [&thread](ServingThread::Answer answer) { asio::post(thread, std::move(answer)); };
    };
    return {{"the loop", in_turn(io_), 0}, {"the files' thread", in_turn(files_thread_), limits::busy_seconds_max}};
}

/// Says goodbye in both directions; the loop ends when that has left.
void RelayServer::Running::end(std::optional<Error> error) {
    if (end_by_s_) return;
    end_by_s_ = now_s() + limits::goodbye_seconds;
    if (const std::string counts = core_.counts().text(); !counts.empty()) spdlog::info("{}", counts);
    {
        const std::lock_guard lock(mutex_);
        error_ = std::move(error);
    }
    peers_.stop_listening();
    carry_out(core_.dismiss(now_s()));
    master_.finish(wire::Goodbye(wire::GoodbyeReason::done, "the relay ends"));
}

void RelayServer::Running::stop_if_done() {
    if (end_by_s_ && ((left_master_ && peers_.empty()) || now_s() >= *end_by_s_)) io_.stop();
}

void RelayServer::Running::tick() {
    carry_out(core_.tick(now_s()));
    stop_if_done();
    {
        std::string line = master_.welcome() ? "a relay of " : "a relay that waits for ";
        line += master_.master().text() + "; " + core_.summary(now_s());
        const std::lock_guard lock(mutex_);
        summary_ = std::move(line);
    }
    timer_.expires_after(tick_interval);
    timer_.async_wait([this](const boost::system::error_code& error) {
        if (!error) tick();
    });
}

// The connections

void RelayServer::Running::on_peer(SessionId session, const std::string& address) {
    carry_out(core_.on_connect(session, address, now_s()));
}

void RelayServer::Running::on_peer_message(SessionId session, wire::Message message, std::uint64_t request_id) {
    if (std::holds_alternative<wire::StatusRequest>(message)) core_.farm_counts().traffic = peers_.traffic();
    carry_out(core_.on_message(session, std::move(message), request_id, now_s()));
}

void RelayServer::Running::on_peer_gone(SessionId session) { carry_out(core_.on_disconnect(session, now_s())); }

void RelayServer::Running::on_peer_closed(const net::Closed& closed) {
    core_.farm_counts().count(closed);
    stop_if_done();
}

void RelayServer::Running::on_accept_failed(const std::string& why) {
    carry_out(core_.on_discarded(Discard::accept_failed, "nobody can connect: " + why, now_s()));
}

void RelayServer::Running::on_master_open() { carry_out(core_.on_upstream_open(now_s())); }

void RelayServer::Running::on_master_message(wire::Message message) {
    carry_out(core_.on_upstream_message(std::move(message), now_s()));
}

void RelayServer::Running::on_master_lost(const net::Closed& closed) {
    core_.counts().count(closed);
    carry_out(core_.on_upstream_lost(closed.goodbye, now_s()));
}

void RelayServer::Running::on_master_finished(const std::optional<net::Closed>& closed) {
    if (closed) core_.counts().count(*closed);
    left_master_ = true;
    stop_if_done();
}

// The core's effects

void RelayServer::Running::carry_out(relay::Effects effects) {
    for (relay::Effect& effect : effects) std::visit([&](auto& each) { carry_out(each); }, effect);
    merged_ = core_.particles_merged();
    master_.pump();
}

template <class Work, class Then>
void RelayServer::Running::slowly(Work work, Then then) {
    asio::post(files_thread_, [this, work = std::move(work), then = std::move(then)]() mutable {
        auto result = work();
        asio::post(io_, [then = std::move(then), result = std::move(result)]() mutable { then(std::move(result)); });
    });
}

template <class Serve, class Request>
void RelayServer::Running::serve(const Serve& effect, Request request) {
    peers_.begin_slow_request(effect.session);
    slowly([this, request] { return files_->answer(request); },
           [this, effect](wire::Message reply) {
               peers_.end_slow_request(effect.session);
               carry_out(core_.on_served(effect.session, std::move(reply), effect.request_id, now_s()));
           });
}

void RelayServer::Running::carry_out(const relay::KeepFile& keep) {
    slowly([this, keep] { return files_->put(*keep.bytes); },
           [this, file = keep.file](const Result<Digest>& kept) {
               if (!kept) spdlog::error("file {} is not kept: {}", file.hex(), kept.error().sentence);
               const Result<void> done = kept ? Result<void>() : Result<void>(kept.error());
               carry_out(core_.on_file_kept(file, done, now_s()));
           });
}

void RelayServer::Running::carry_out(const relay::RemoveFile& remove) {
    slowly([this, file = remove.file] { return files_->remove(file); },
           [](const Result<void>& removed) {
               if (!removed) spdlog::warn("{}", removed.error().sentence);
           });
}

void RelayServer::Running::carry_out(const relay::PrepareLent& prepare) {
    slowly(
        [this, prepare] {
            return relay::prepare_lent(prepare, [this](const Digest& file) { return files_->read(file); });
        },
        [this, info = prepare.info](Result<relay::Preparation> prepared) {
            if (!prepared) spdlog::error("job {} can't be relayed: {}", info.job, prepared.error().sentence);
            carry_out(core_.on_prepared(info, std::move(prepared), now_s()));
        });
}

void RelayServer::Running::carry_out(const Discarded& discarded) {
    spdlog::info("{} {}: {}", name_of(discarded.reason), discarded.times, discarded.sentence);
}

void RelayServer::Running::carry_out(const worker::Discarded& discarded) {
    spdlog::info("{} {}: {}", name_of(discarded.reason), discarded.times, discarded.sentence);
}

}  // namespace lumenfarm
