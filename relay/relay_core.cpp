#include "relay/relay_core.h"

#include "common/support/counted.h"
#include "common/support/ensure.h"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace lumenfarm::relay {

RelayCore::RelayCore(const RelayIdentity& identity, MasterPolicy farm, double drain_seconds,
                     std::size_t bytes_in_flight)
    : identity_(identity),
      drain_seconds_(drain_seconds),
      reconnect_seconds_(farm.reconnect_seconds),
      bytes_in_flight_(bytes_in_flight),
      farm_(farm) {
    ensure(!farm.upstream.empty() && farm.instance == identity.instance, "a relay has a master above");
}

Effects RelayCore::settle_and_take(double now_s) {
    merge_pending(now_s);
    for (auto& [id, job] : jobs_) end_drain_if_done(id, job, now_s);
    close_what_is_due(now_s);
    pull();  // first, so that what goes back does not come again
    send_returns();
    finish_if_drained(now_s);
    return std::exchange(effects_, {});
}

/// What the farm below wants done. Nothing of a lent job goes to the disk.
void RelayCore::route(lumenfarm::Effects effects) {
    for (lumenfarm::Effect& effect : effects)
        std::visit(
            [&]<class E>(E& each) {
                if constexpr (std::is_same_v<E, StoreResult>) {
                    pending_.push_back(std::move(each));
                } else if constexpr (std::is_same_v<E, ServeManifest>) {
                    serve(each);
                } else if constexpr (std::is_constructible_v<Effect, E>) {
                    effects_.push_back(std::move(each));
                } else {
                    constexpr bool of_the_disk = std::is_same_v<E, StoreLeases> || std::is_same_v<E, StoreChunk>;
                    ensure(of_the_disk, "a relay keeps nothing of a job");
                }
            },
            effect);
}

Effects RelayCore::on_upstream_open(double now_s) {
    wire::Hello hello(wire::Role::relay, identity_.name, identity_.instance);
    hello.isa = identity_.isa;
    hello.fingerprint = identity_.fingerprint;
    send(std::move(hello));
    return settle_and_take(now_s);
}

Effects RelayCore::on_upstream_message(wire::Message message, double now_s) {
    std::visit(
        [&]<class M>(M& m) {
            if constexpr (std::is_same_v<M, wire::Welcome>) {
                greet(m, now_s);
            } else if constexpr (std::is_same_v<M, wire::JobInfo>) {
                take_job(m, now_s);
            } else if constexpr (std::is_same_v<M, wire::Lease>) {
                take_lease(std::move(m));
                route(farm_.settle(now_s));
            } else if constexpr (std::is_same_v<M, wire::ResultAck>) {
                take_ack(m);
            } else if constexpr (std::is_same_v<M, wire::JobGone>) {
                drop_job(m.job, now_s);
            } else if constexpr (std::is_same_v<M, wire::Drain>) {
                const auto job = jobs_.find(m.job);
                if (m.job == 0)
                    begin_drain(now_s);
                else if (job != jobs_.end())
                    drain_job(job->second, now_s, now_s + limits::finish_seconds / 2);
            } else if constexpr (std::is_same_v<M, wire::Manifest>) {
                fetch_ ? take_requests(fetch_->on_manifest(m)) : ignore(m);
            } else if constexpr (std::is_same_v<M, wire::Chunk>) {
                fetch_ ? take_requests(fetch_->on_chunk(m)) : ignore(m);
            } else if constexpr (std::is_same_v<M, wire::Refusal>) {
                // of an earlier fetch there may come as many as it had asked for chunks
                const bool current = fetch_.has_value() && m.file == fetch_->scene();
                current ? fail_fetch(m.file, m.sentence) : ignore(m);
            } else if constexpr (!std::is_same_v<M, wire::Heartbeat> && !std::is_same_v<M, wire::HeartbeatReply>) {
                ignore(m);
            }
        },
        message);
    return settle_and_take(now_s);
}

void RelayCore::ignore(const wire::Message& message) {
    count(worker::Discard::unexpected_message, 1, std::string(wire::name_of(message)));
}

void RelayCore::count(worker::Discard reason, std::uint64_t times, std::string sentence) {
    if (times == 0) return;
    counts_.discards.count(reason, times);
    effects_.push_back(worker::Discarded{reason, times, std::move(sentence)});
}

Effects RelayCore::on_upstream_lost(const std::optional<wire::Goodbye>& goodbye, double now_s) {
    if (welcome_) lost_s_ = now_s;
    welcome_ = false;
    results_.rewind();
    for (auto& [id, job] : jobs_) {
        job.confirmed = false;
        job.parts_told.reset();
    }
    const bool unwanted = goodbye && (goodbye->reason == wire::GoodbyeReason::refused ||
                                      goodbye->reason == wire::GoodbyeReason::unsupported_protocol);
    if (unwanted && !finished_) {
        finished_ = true;
        count(worker::Discard::result_undelivered, results_.size(), "the master does not want this relay");
        effects_.push_back(GiveUp{"the master does not want this relay: " + goodbye->text});
    }
    return settle_and_take(now_s);
}

std::optional<wire::Message> RelayCore::next_bulk() {
    if (!welcome_) return std::nullopt;
    return results_.next(credit_, [&](JobId id) {
        const auto job = jobs_.find(id);
        return job != jobs_.end() && job->second.confirmed;
    });
}

Effects RelayCore::on_connect(SessionId session, const std::string& address, double now_s) {
    route(farm_.on_connect(session, address, now_s));
    return settle_and_take(now_s);
}

Effects RelayCore::on_message(SessionId session, wire::Message message, std::uint64_t request_id, double now_s) {
    route(farm_.on_message(session, std::move(message), request_id, now_s));
    return settle_and_take(now_s);
}

Effects RelayCore::on_disconnect(SessionId session, double now_s) {
    route(farm_.on_disconnect(session, now_s));
    return settle_and_take(now_s);
}

Effects RelayCore::on_discarded(lumenfarm::Discard reason, std::string sentence, double now_s) {
    route(farm_.on_discarded(reason, std::move(sentence), now_s));
    return settle_and_take(now_s);
}

Effects RelayCore::on_served(SessionId session, wire::Message reply, std::uint64_t request_id, double now_s) {
    route(farm_.on_served(session, std::move(reply), request_id, now_s));
    return settle_and_take(now_s);
}

Effects RelayCore::tick(double now_s) {
    route(farm_.tick(now_s));
    for (auto& [id, job] : jobs_) give_back_what_is_hopeless(job);
    give_back_what_nobody_traces(now_s);
    tell_parts();
    return settle_and_take(now_s);
}

/// Strategy subspaces: what the workers hold together is what the relay is preferred for.
void RelayCore::tell_parts() {
    for (auto& [id, job] : jobs_) {
        const bool may = welcome_ && job.confirmed && job.phase == Phase::running;
        if (!may || job.info.spec.strategy != Strategy::subspaces) continue;
        wire::PartsHeld held = farm_.parts_held(id);
        if (job.parts_told == held) continue;
        job.parts_told = held;
        send(std::move(held));
    }
}

/// A set for each thread ahead, in a few leases: enough that no worker waits for the master above, and no more, since
/// what is here is not shared out any more.
void RelayCore::pull() {
    if (!welcome_) return;
    const std::uint32_t threads = farm_.worker_threads();
    const std::uint32_t most = std::clamp(threads, 1u, limits::relay_sets_ahead);
    std::uint64_t ahead = 0;
    for (const auto& [id, job] : jobs_) ahead += sets_ahead(id, job);
    const bool room = !drain_by_s_ && threads > 0 && pending_.empty();
    const std::uint64_t sets = room && ahead < most ? most - ahead : 0;
    const wire::Pull wish(static_cast<std::uint32_t>(sets), leases_received_, threads,
                          std::max(1u, (threads + most - 1) / most));
    if (wish == wished_) return;
    wished_ = wish;
    send(wish);
}

void RelayCore::send_returns() {
    if (!welcome_) return;
    for (wire::ReturnLeases& returned : returns_.take([&](std::uint64_t lease) { return claimed(lease); }))
        send(std::move(returned));
}

Effects RelayCore::drain(double now_s) {
    begin_drain(now_s);
    return settle_and_take(now_s);
}

void RelayCore::begin_drain(double now_s) {
    if (!drain_by_s_) drain_by_s_ = now_s + drain_seconds_;
}

Effects RelayCore::end_now(double now_s) {
    drain_by_s_ = now_s;
    return settle_and_take(now_s);
}

void RelayCore::finish_if_drained(double now_s) {
    if (!drain_by_s_ || finished_) return;
    for (auto& [id, job] : jobs_)
        if (!job.drain_by_s) drain_job(job, now_s, now_s + (*drain_by_s_ - now_s) / 2);
    const bool nothing_left =
        results_.empty() && returns_.empty() && pending_.empty() &&
        std::all_of(jobs_.begin(), jobs_.end(), [](const auto& entry) {
            return entry.second.sets.empty() && (!entry.second.open || entry.second.open->empty());
        });
    if (!nothing_left && welcome_ && now_s < *drain_by_s_) return;
    finished_ = true;
    count(worker::Discard::result_undelivered, results_.size(), "the relay ends");
    effects_.push_back(Finished{});
}

Effects RelayCore::dismiss(double now_s) {
    route(farm_.stop(now_s, 0));
    return std::exchange(effects_, {});
}

std::string RelayCore::summary(double now_s) const {
    std::string line = farm_.summary(now_s);
    if (!results_.empty()) line += "; " + counted(results_.size(), "result") + " handed up, not acknowledged yet";
    return drain_by_s_ ? "ending: " + line : line;
}

std::optional<std::string> RelayCore::contradiction() const {
    if (const auto fault = farm_.contradiction()) return fault;
    for (const auto& [id, job] : jobs_) {
        const std::string name = "job " + std::to_string(id) + ": ";
        if (job.phase != Phase::running || waits_for_room(id)) continue;
        const std::uint64_t lent = farm_.ledger(id)->lent();
        if (lent != job.sets.left())
            return name + std::to_string(job.sets.left()) + " particles are lent from above, " + std::to_string(lent) +
                   " below";
    }
    return std::nullopt;
}

}  // namespace lumenfarm::relay
