#include "master/server_session.h"

#include "common/scene/scene_file.h"

#include <spdlog/spdlog.h>
#include <boost/asio/post.hpp>

#include <ctime>
#include <random>
#include <utility>

namespace lumenfarm {

namespace asio = boost::asio;

namespace {

constexpr auto tick_interval = std::chrono::milliseconds(200);

}  // namespace

MasterServer::Running::Running(const MasterPolicy& policy, StorageLock lock, std::unique_ptr<Disk> disk,
                               std::unique_ptr<Storage> storage)
    : lock_(std::move(lock)), disk_(std::move(disk)), storage_(std::move(storage)), core_(policy) {}

MasterServer::Running::~Running() { stop(); }

double MasterServer::Running::now_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void MasterServer::Running::run(std::vector<JobRecord> records, const std::vector<std::string>& damages) {
    for (const std::string& damage : damages) discard(Discard::stored_record_damaged, damage);
    for (JobRecord& record : records) core_.restore(std::move(record));
    tick();
    thread_ = std::thread([this] { io_.run(); });
}

void MasterServer::Running::stop() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] {
        stopping_ = true;
        peers_.stop_listening();
        carry_out(core_.stop(now_s(), failure() ? 0 : limits::stop_seconds));
        commit(true);
        end_if_done();
    });
    thread_.join();
    storage_thread_.join();
    peers_.detach();
    for (auto& [id, reply] : replies_)
        reply.set_value(wire::Refusal(wire::RefusalReason::failed, "the master was stopped"));
    replies_.clear();
}

/// The loop goes on until the disk has what it was asked to keep.
void MasterServer::Running::end_if_done() {
    if (!stopping_ || !core_.stopped()) return;
    if (!end_by_s_) end_by_s_ = now_s() + limits::goodbye_seconds;
    if (slow_works_ == 0 && (peers_.empty() || now_s() >= *end_by_s_)) io_.stop();
}

void MasterServer::Running::tick() {
    carry_out(core_.tick(now_s()));
    commit(true);
    end_if_done();
    {
        std::string line = core_.summary(now_s());
        const std::lock_guard lock(changed_mutex_);
        summary_ = std::move(line);
    }
    timer_.expires_after(tick_interval);
    timer_.async_wait([this](const boost::system::error_code& error) {
        if (!error) tick();
    });
}

std::string MasterServer::Running::summary() const {
    const std::lock_guard lock(changed_mutex_);
    return summary_;
}

std::vector<ServingThread> MasterServer::Running::threads() {
    const auto in_turn = [](auto& thread) {
        return [&thread](ServingThread::Answer answer) { asio::post(thread, std::move(answer)); };
    };
    return {{"the loop", in_turn(io_), 0}, {"the disk", in_turn(storage_thread_), limits::busy_seconds_max}};
}

void MasterServer::Running::wait_for_change(double seconds) {
    std::unique_lock lock(changed_mutex_);
    const std::uint64_t seen = changes_;
    changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return changes_ != seen; });
}

void MasterServer::Running::on_peer(SessionId session, const std::string& address) {
    carry_out(core_.on_connect(session, address, now_s()));
}

void MasterServer::Running::on_peer_message(SessionId session, wire::Message message, std::uint64_t request_id) {
    if (std::holds_alternative<wire::StatusRequest>(message)) core_.counts().traffic = peers_.traffic();
    asking_ = session;
    carry_out(core_.on_message(session, std::move(message), request_id, now_s()));
    asking_ = 0;
}

void MasterServer::Running::on_peer_gone(SessionId session) { carry_out(core_.on_disconnect(session, now_s())); }

void MasterServer::Running::on_peer_closed(const net::Closed& closed) {
    core_.counts().count(closed);
    end_if_done();
}

void MasterServer::Running::on_accept_failed(const std::string& why) {
    discard(Discard::accept_failed, "nobody can connect: " + why);
}

void MasterServer::Running::carry_out(Effects effects) {
    for (Effect& effect : effects) std::visit([&](auto& each) { carry_out(std::move(each)); }, effect);
    {
        const std::lock_guard lock(changed_mutex_);
        ++changes_;
    }
    changed_.notify_all();
}

void MasterServer::Running::carry_out(Send send) {
    if (send.session == embedding_session) {
        const auto reply = replies_.find(send.request_id);
        if (reply == replies_.end()) return;
        reply->second.set_value(std::move(send.message));
        replies_.erase(reply);
        return;
    }
    peers_.carry_out(send);
}

template <class Work, class Then>
void MasterServer::Running::slowly(Work work, Then then) {
    ++slow_works_;
    asio::post(storage_thread_, [this, work = std::move(work), then = std::move(then)]() mutable {
        auto result = work();
        asio::post(io_,
                   [this, then = std::move(then), result = std::move(result), broken = storage_->broken()]() mutable {
                       --slow_works_;
                       broken ? fail(*broken) : then(std::move(result));
                       end_if_done();
                   });
    });
}

void MasterServer::Running::fail(const Error& error) {
    for (auto& [id, reply] : replies_) reply.set_value(wire::Refusal(wire::RefusalReason::failed, error.sentence));
    replies_.clear();
    if (failure()) return;
    spdlog::critical("{}; the master ends, and recovers from its disk when it starts again", error.sentence);
    {
        const std::lock_guard lock(changed_mutex_);
        failure_ = error;
    }
    changed_.notify_all();
    if (stopping_) carry_out(core_.stop(now_s(), 0));
}

std::optional<Error> MasterServer::Running::failure() const {
    const std::lock_guard lock(changed_mutex_);
    return failure_;
}

void MasterServer::Running::carry_out(Admit admit) {
    struct Admitted {
        Result<std::vector<std::uint32_t>> missing;
        std::vector<Digest> displaced;
    };
    slowly(
        [this, admit] {
            auto missing = storage_->admit(admit);
            return Admitted{std::move(missing), storage_->files().take_displaced()};
        },
        [this, admit](const Admitted& admitted) {
            for (const Digest& file : admitted.displaced)
                discard(Discard::upload_displaced, "the upload of " + file.hex() + " made room for newer ones");
            const auto& missing = admitted.missing;
            if (missing && missing->empty()) spdlog::info("job {} is accepted", admit.record.id());
            carry_out(core_.on_admitted(admit, missing, now_s()));
        });
}

void MasterServer::Running::carry_out(StoreChunk store) {
    const SessionId session = asking_;
    peers_.begin_slow_request(session);
    slowly([this, chunk = std::move(store.chunk)] { return storage_->put_chunk(chunk); },
           [this, session](const Result<void>& stored) {
               if (!stored) discard(Discard::chunk_refused, stored.error().sentence);
               peers_.end_slow_request(session);
           });
}

template <class Serve>
void MasterServer::Running::serve(Serve effect) {
    peers_.begin_slow_request(effect.session);
    slowly([this, effect] { return storage_->serve(effect); },
           [this, effect](wire::Message reply) {
               peers_.end_slow_request(effect.session);
               carry_out(core_.on_served(effect.session, std::move(reply), effect.request_id, now_s()));
           });
}

void MasterServer::Running::carry_out(Prepare prepare) {
    slowly([this, prepare] { return storage_->prepare(prepare); },
           [this, job = prepare.job.id()](Result<RecoveredJob> recovered) {
               if (!recovered) spdlog::error("job {} fails: {}", job, recovered.error().sentence);
               if (recovered) {
                   spdlog::info("job {} {} {} particles; {}", job,
                                recovered->balance.particles > 0 ? "goes on after" : "begins with",
                                recovered->balance.particles, recovered->prepared->octree);
                   if (recovered->recut)
                       spdlog::info(
                           "job {} is cut in subspaces anew: of the work so far the largest share was {:.2f} times the "
                           "mean, and is {:.2f} now",
                           job, recovered->recut->now, recovered->recut->learned);
               }
               carry_out(core_.on_prepared(job, std::move(recovered), now_s()));
           });
}

void MasterServer::Running::carry_out(MeasureCut measure) {
    slowly([this, measure] { return storage_->measure(measure); },
           [this, measure](const Evenness& evenness) {
               spdlog::info("job {}: of its work the largest share of a subspace is {:.2f} times the mean", measure.job,
                            evenness.now);
               carry_out(core_.on_cut_measured(measure, evenness, now_s()));
           });
}

void MasterServer::Running::carry_out(StoreResult store) {
    commits_.add(std::move(store));
    commit(false);
}

void MasterServer::Running::commit(bool leases_too) {
    const auto batch = commits_.begin(leases_too);
    if (!batch) return;
    slowly([this, batch] { return storage_->commit(*batch); },
           [this, batch](const Result<std::map<JobId, Merged>>& stored) {
               commits_.end(*batch, stored.has_value());
               if (!stored && !batch->results.empty())
                   spdlog::error("{}; the same is tried again", stored.error().sentence);
               carry_out(core_.on_results_stored(batch->tickets(), stored, now_s()));
               commit(false);
           });
}

void MasterServer::Running::carry_out(StoreSnapshot store) {
    slowly([this, store] { return storage_->store(store); },
           [this, store](const Result<bool>& stored) {
               if (!stored) spdlog::warn("no snapshot of job {}: {}", store.job, stored.error().sentence);
               if (stored && *stored && store.last) spdlog::info("a snapshot of job {} is kept", store.job);
               carry_out(core_.on_snapshot_stored(store, now_s()));
           });
}

void MasterServer::Running::carry_out(StoreRecord store) {
    slowly([this, store] { return storage_->put(store); },
           [this, store](const Result<void>& stored) {
               const JobRecord& record = store.record;
               if (!stored) spdlog::error("{}; the record of job {} waits", stored.error().sentence, record.id());
               if (stored) spdlog::info("job {} is {}", record.id(), name_of(record.status.state));
               carry_out(core_.on_record_stored(store, stored, now_s()));
           });
}

void MasterServer::Running::carry_out(Retract retract) {
    spdlog::warn("what {} workers have traced for job {} is thrown away: others contradict it{}",
                 retract.machines.size(), retract.record.id(), retract.all ? "; the job begins anew" : "");
    slowly(
        [this, retract] { return storage_->retract(retract); },
        [this, retract](Result<Retracted> left) { carry_out(core_.on_retracted(retract, std::move(left), now_s())); });
}

void MasterServer::Running::carry_out(PutAside aside) {
    slowly([this, aside] { return storage_->put_aside(aside); },
           [this, aside](const Result<void>&) {
               spdlog::info("job {} is put aside", aside.job);
               carry_out(core_.on_put_aside(aside, now_s()));
           });
}

void MasterServer::Running::carry_out(RemoveJob remove) {
    slowly([this, remove] { return storage_->remove(remove); },
           [this, remove](const Result<void>& removed) {
               if (removed) spdlog::info("job {} is removed", remove.job);
               if (!removed) spdlog::error("job {} is not removed: {}", remove.job, removed.error().sentence);
               carry_out(core_.on_removed(remove, removed, now_s()));
           });
}

void MasterServer::Running::carry_out(StoreSolution store) {
    slowly([this, store] { return storage_->store(store); },
           [this, store](const Result<JobRecord>& stored) {
               const JobId job = store.record.id();
               if (stored) spdlog::info("job {} ends; digest {}", job, stored->status.digest->hex());
               if (!stored) spdlog::error("{}; the solution of job {} waits", stored.error().sentence, job);
               carry_out(core_.on_solution_stored(store, stored, now_s()));
           });
}

void MasterServer::Running::carry_out(const Discarded& discarded) {
    const auto level = group_of(discarded.reason) == "dropped" ? spdlog::level::warn : spdlog::level::info;
    spdlog::log(level, "{} {}: {}", name_of(discarded.reason), discarded.times, discarded.sentence);
}

void MasterServer::Running::discard(Discard reason, const std::string& sentence) {
    carry_out(core_.on_discarded(reason, sentence, now_s()));
}

Result<JobId> MasterServer::Running::submit(const JobSpec& spec, std::span<const std::byte> scene_bytes) {
    wire::FileManifest manifest(scene_digest(scene_bytes), scene_bytes.size(), chunk_digests(scene_bytes));
    std::promise<Result<Digest>> put;
    std::future<Result<Digest>> kept = put.get_future();
    asio::post(storage_thread_, [&] { put.set_value(storage_->put_scene(scene_bytes)); });
    if (const auto file = kept.get(); !file) return file.error();
    std::promise<wire::Message> promise;
    std::future<wire::Message> reply = promise.get_future();
    std::random_device entropy;
    const std::uint64_t key = std::uint64_t{entropy()} << 32 | entropy();
    asio::post(io_, [&, this] {
        const std::uint64_t request = next_request_++;
        replies_.emplace(request, std::move(promise));
        wire::Submit submit(key, spec, std::move(manifest));
        carry_out(core_.on_message(embedding_session, std::move(submit), request, now_s()));
    });
    const wire::Message answer = reply.get();
    if (const auto* accepted = std::get_if<wire::SubmitReply>(&answer); accepted && accepted->job != 0)
        return accepted->job;
    const auto* refusal = std::get_if<wire::Refusal>(&answer);
    if (!refusal) return failed("the scene was lost from the storage while the job was submitted");
    return refusal->reason == wire::RefusalReason::bad_request ? bad_input(refusal->sentence)
                                                               : failed(refusal->sentence);
}

}  // namespace lumenfarm
