#include "master/master_core.h"

#include "common/support/ensure.h"

#include <utility>

namespace lumenfarm {

Effects MasterCore::settle_and_take(double now_s) {
    if (!stopping_) {
        give_work(now_s);
        prepare_next(now_s);
    } else {
        stop_when_answered(now_s);
    }
    for (auto& [id, job] : jobs_) retract_if_quiet(job);
    collect_ended_leases();
    return std::exchange(effects_, {});
}

void MasterCore::send(SessionId session, wire::Message message, std::uint64_t request_id) {
    effects_.push_back(Send{session, std::move(message), request_id});
}

Effects MasterCore::on_connect(SessionId session, const std::string& address, double now_s) {
    Session fresh;
    fresh.id = session;
    fresh.address = address;
    fresh.connected_s = fresh.heard_s = now_s;
    const bool full = sessions_.size() >= limits::sessions_max;
    ensure(sessions_.emplace(session, std::move(fresh)).second, "a session connects once");
    if (full)
        send_off(session, wire::GoodbyeReason::farm_full, Discard::farm_full, "this master has no room for more",
                 now_s);
    return settle_and_take(now_s);
}

Effects MasterCore::on_message(SessionId session, wire::Message message, std::uint64_t request_id, double now_s) {
    if (stopping_) return settle_and_take(now_s);
    if (session == embedding_session) {
        Session embedding;
        embedding.role = Submitter{};
        dispatch(embedding, message, request_id, now_s);
    } else if (const auto found = sessions_.find(session); found != sessions_.end()) {
        found->second.heard_s = now_s;
        dispatch(found->second, message, request_id, now_s);
    }
    return settle_and_take(now_s);
}

Effects MasterCore::on_disconnect(SessionId session, double now_s) {
    forget(session, now_s);
    return settle_and_take(now_s);
}

Effects MasterCore::on_served(SessionId session, wire::Message reply, std::uint64_t request_id, double now_s) {
    if (const auto* refusal = std::get_if<wire::Refusal>(&reply)) counts_.refused_requests.count(refusal->reason);
    send(session, std::move(reply), request_id);
    return settle_and_take(now_s);
}

Effects MasterCore::on_discarded(Discard reason, std::string sentence, double now_s) {
    count(reason, 1, std::move(sentence));
    return settle_and_take(now_s);
}

void MasterCore::count(Discard reason, std::uint64_t times, std::string sentence) {
    if (times == 0) return;
    counts_.discards.count(reason, times);
    effects_.push_back(Discarded{reason, times, std::move(sentence)});
}

Effects MasterCore::tick(double now_s) {
    for (auto& [id, job] : jobs_) {
        if (!job.active) continue;
        const std::uint64_t expired = job.active->ledger().expire(now_s);
        job.record.status.leases_expired += expired;
        count(Discard::lease_expired, expired, "of job " + std::to_string(id));
        sample_rate(job, now_s);
        store_snapshot(job, now_s);
        pause_if_stuck(job, now_s);
        look_at_cut(job, now_s);
        if (job.phase == Phase::running && drains(job) && now_s >= job.end_by_s) {
            job.gives_flights_up = true;
            wind_up(job, now_s);
        }
        end_if_finished(job, now_s);
    }
    count(Discard::audit_hopeless, audits_.expire(now_s));
    try_again(now_s);
    remove_old_jobs(now_s);
    give_twins(now_s);
    return settle_and_take(now_s);
}

}  // namespace lumenfarm
