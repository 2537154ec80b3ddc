#include "worker/worker_core.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace lumenfarm::worker {

namespace {

/// What is left beside the program itself, and results on their way.
std::optional<std::uint64_t> bytes_for_parts(const WorkerIdentity& identity) {
    if (identity.memory_bytes == 0) return std::nullopt;
    const std::uint64_t beside =
        limits::worker_bytes + limits::result_bytes_in_flight + 2 * identity.threads * limits::result_close_bytes;
    return identity.memory_bytes > beside ? identity.memory_bytes - beside : 0;
}

}  // namespace

WorkerCore::WorkerCore(const WorkerIdentity& identity, double drain_seconds)
    : identity_(identity),
      drain_seconds_(drain_seconds),
      slots_(identity.threads),
      shelf_(bytes_for_parts(identity), identity.instance, identity.parts_only) {
    ensure(identity.threads > 0, "a worker traces");
}

Effects WorkerCore::settle_and_take(double now_s) {
    bring_next();
    for (std::size_t i = 0; i < slots_.size(); ++i) feed(i, now_s);
    bring_next();  // a slot may have taken the last set that needed something
    pull();        // first, so that one that ends is not given its own leases again
    send_returns();
    finish_if_drained(now_s);
    return std::exchange(effects_, {});
}

Effects WorkerCore::on_connect(double now_s) {
    wire::Hello hello(wire::Role::worker, identity_.name, identity_.instance);
    hello.threads = identity_.threads;
    hello.memory_bytes = identity_.memory_bytes;
    hello.isa = identity_.isa;
    hello.fingerprint = identity_.fingerprint;
    send(std::move(hello));
    return settle_and_take(now_s);
}

Effects WorkerCore::on_message(wire::Message message, double now_s) {
    std::visit(
        [&]<class M>(M& m) {
            if constexpr (std::is_same_v<M, wire::Welcome>) {
                greet(m, now_s);
            } else if constexpr (std::is_same_v<M, wire::JobInfo>) {
                take_job(m);
            } else if constexpr (std::is_same_v<M, wire::Lease>) {
                take_lease(m);
            } else if constexpr (std::is_same_v<M, wire::ResultAck>) {
                take_ack(m);
            } else if constexpr (std::is_same_v<M, wire::JobGone>) {
                drop_job(m.job);
            } else if constexpr (std::is_same_v<M, wire::Drain>) {
                m.job == 0 ? begin_drain(now_s) : drain_job(m.job);
            } else if constexpr (std::is_same_v<M, wire::Manifest>) {
                fetch_ ? take_requests(fetch_->on_manifest(m)) : ignore(m);
            } else if constexpr (std::is_same_v<M, wire::Chunk>) {
                fetch_ ? take_requests(fetch_->on_chunk(m)) : ignore(m);
            } else if constexpr (std::is_same_v<M, wire::Refusal>) {
                // of an earlier fetch there may come as many as it had asked for chunks
                const bool current = fetch_.has_value() && m.file == fetch_->scene();
                current ? fail_fetch(m.sentence) : ignore(m);
            } else if constexpr (!std::is_same_v<M, wire::Heartbeat> && !std::is_same_v<M, wire::HeartbeatReply>) {
                ignore(m);
            }
        },
        message);
    return settle_and_take(now_s);
}

void WorkerCore::ignore(const wire::Message& message) {
    count(Discard::unexpected_message, 1, std::string(wire::name_of(message)));
}

void WorkerCore::count(Discard reason, std::uint64_t times, std::string sentence) {
    if (times == 0) return;
    counts_.discards.count(reason, times);
    effects_.push_back(Discarded{reason, times, std::move(sentence)});
}

Effects WorkerCore::on_discarded(Discard reason, std::string sentence, double now_s) {
    count(reason, 1, std::move(sentence));
    return settle_and_take(now_s);
}

/// States what is still held, before anything is pulled.
void WorkerCore::greet(const wire::Welcome& welcome, double now_s) {
    welcome_ = true;
    wished_ = 0;
    leases_received_ = 0;
    credit_ = welcome.results_in_flight;
    largest_credit_ = std::max(largest_credit_, credit_);
    // after this long the master has given the leases to others
    if (lost_s_ && now_s - *lost_s_ > welcome.reconnect_seconds) {
        count(Discard::set_outlived, queue_.size(), "the connection was away for too long");
        queue_.clear();
    }
    lost_s_.reset();
    // what results still claim is stated, and goes back after them
    returns_.keep_only([&](std::uint64_t lease) { return results_.claims(lease); });
    send(wire::Progress(0, leases_held()));
    drop_jobs_not_held();
    if (!fetch_) return;
    for (wire::Message& request : fetch_->begin_session()) send(std::move(request));
}

Effects WorkerCore::on_disconnect(const std::optional<wire::Goodbye>& goodbye, double now_s) {
    if (welcome_) lost_s_ = now_s;
    welcome_ = false;
    results_.rewind();
    for (auto& [id, job] : jobs_) job.confirmed = false;
    const bool unwanted = goodbye && (goodbye->reason == wire::GoodbyeReason::refused ||
                                      goodbye->reason == wire::GoodbyeReason::unsupported_protocol);
    if (unwanted && !finished_) {
        finished_ = true;
        count(Discard::result_undelivered, results_.size(), "the master does not want this worker");
        effects_.push_back(GiveUp{"the master does not want this worker: " + goodbye->text});
    }
    return settle_and_take(now_s);
}

Effects WorkerCore::tick(double now_s) {
    interrupt_late(now_s);
    return settle_and_take(now_s);
}

void WorkerCore::pull() {
    if (!welcome_) return;
    std::size_t held = queue_.size();
    for (const Slot& slot : slots_) held += slot.lease.has_value();
    const std::size_t backlog = std::min<std::size_t>(2 * slots_.size(), limits::leases_per_worker_max);
    std::uint32_t room = held < backlog ? static_cast<std::uint32_t>(backlog - held) : 0;
    if (drain_by_s_ || !room_for_results()) room = 0;
    if (room == wished_) return;
    wished_ = room;
    send(wire::Pull(room, leases_received_));
}

void WorkerCore::send_returns() {
    if (!welcome_) return;
    for (wire::ReturnLeases& returned : returns_.take([&](std::uint64_t lease) { return results_.claims(lease); }))
        send(std::move(returned));
}

std::vector<wire::LeaseProgress> WorkerCore::leases_held() const {
    std::map<std::uint64_t, JobId> job_by_lease = results_.leases();
    for (const wire::Lease& lease : queue_) job_by_lease.emplace(lease.lease, lease.job);
    for (const Slot& slot : slots_) {
        if (slot.abandoned) continue;
        if (slot.lease) job_by_lease.emplace(slot.lease->lease, slot.job);
        for (const auto& [lease, epoch] : slot.open_leases) job_by_lease.emplace(lease, slot.job);
    }
    std::vector<wire::LeaseProgress> held;
    for (const auto& [lease, job] : job_by_lease)
        if (held.size() < limits::leases_per_worker_max) held.emplace_back(job, lease, 0);
    return held;
}

std::optional<wire::Message> WorkerCore::next_bulk() {
    if (!welcome_) return std::nullopt;
    // a master that has just started may not be ready for them
    return results_.next(credit_, [&](JobId id) {
        const auto job = jobs_.find(id);
        return job != jobs_.end() && job->second.confirmed;
    });
}

void WorkerCore::take_ack(const wire::ResultAck& ack) {
    const auto parcel = results_.take(ack.result);
    if (!parcel) return ignore(ack);
    counts_.verdicts.count(ack.verdict);
    if (ack.verdict == wire::Verdict::accepted) {
        particles_merged_ += parcel->balance.particles;
    } else {
        count(Discard::result_refused, 1, std::string(wire::name_of(ack.verdict)) + ": " + ack.sentence);
        leave_refused(*parcel);
    }
}

}  // namespace lumenfarm::worker
