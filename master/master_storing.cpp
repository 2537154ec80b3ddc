#include "master/master_core.h"

#include <algorithm>
#include <limits>
#include <utility>

/// The master's core: what is on its way to the disk. Nobody is answered before it lasts (law 6).
namespace lumenfarm {

void MasterCore::store(Session& session, Job& job, StagedResult result) {
    const std::uint64_t ticket = ++tickets_given_;
    auto shared = std::make_shared<const StagedResult>(std::move(result));
    staged_bytes_ += shared->bytes();
    ++job.results_on_their_way;
    effects_.push_back(StoreResult{ticket, job.record.id(), session.machine(), shared});
    Storing storing;
    storing.job = job.record.id();
    storing.worker = session.instance();
    storing.machine = session.machine();
    storing.result = std::move(shared);
    storing_.emplace(ticket, std::move(storing));
}

/// A result with particles that are on their way is answered after them: repeated then, unless it is the same one, sent
/// again over a new connection. False: too many such are waiting.
bool MasterCore::wait_for(WorkerId worker, const wire::ResultDone& done) {
    const auto covers = [&](const wire::Claim& claim, const wire::ResultDone& other) {
        return std::any_of(other.claims.begin(), other.claims.end(), [&](const wire::Claim& theirs) {
            return theirs.range.source == claim.range.source &&
                   theirs.range.first < claim.range.first + claim.range.count &&
                   claim.range.first < theirs.range.first + theirs.range.count;
        });
    };
    for (auto it = storing_.rbegin(); it != storing_.rend(); ++it) {
        Storing& storing = it->second;
        const wire::ResultDone& first = storing.result->done();
        const auto overlaps = [&](const wire::Claim& claim) { return covers(claim, first); };
        if (storing.job != done.job || std::none_of(done.claims.begin(), done.claims.end(), overlaps)) continue;
        if (storing.worker == worker && first.result == done.result) return true;
        const auto same = [&](const auto& other) {
            return other.first == worker && other.second.result == done.result;
        };
        if (std::any_of(storing.repeated.begin(), storing.repeated.end(), same)) return true;
        if (storing.repeated.size() >= limits::repeated_results_max) return false;
        storing.repeated.emplace_back(worker, done);
        return true;
    }
    return false;
}

Effects MasterCore::on_results_stored(std::span<const std::uint64_t> tickets,
                                      const Result<std::map<JobId, Merged>>& stored, double now_s) {
    if (!stored) {
        for (const std::uint64_t ticket : tickets) storing_.at(ticket).waiting_for_space = true;
        if (!tickets.empty()) await_space(stored.error(), now_s);
        return settle_and_take(now_s);
    }
    if (!tickets.empty()) has_space(now_s);
    for (const auto& [id, merged] : *stored) {
        Job* job = find(id);
        if (!job || !job->active) continue;
        for (const FlightQueues::Filed& filed : merged.filed) job->active->file(filed);
        job->active->set_keep_threshold(merged.keep_threshold);
    }
    for (const std::uint64_t ticket : tickets) commit(ticket, now_s);
    for (const auto& [id, merged] : *stored)
        if (Job* job = find(id); job && job->active) end_if_finished(*job, now_s);
    return settle_and_take(now_s);
}

void MasterCore::commit(std::uint64_t ticket, double now_s) {
    const Storing storing = std::move(storing_.extract(ticket).mapped());
    staged_bytes_ -= storing.result->bytes();
    Job& job = jobs_.at(storing.job);
    --job.results_on_their_way;
    job.active->commit(*storing.result);
    if (job.phase == Phase::running) job.end_by_s = now_s + limits::finish_seconds;  // should it drain
    if (job.contributors.size() < limits::sessions_max) job.contributors.insert(storing.machine);
    if (policy_.audit_fraction > 0) audit(job, storing, ticket, now_s);
    answer(storing.worker, storing.job, storing.result->number(), {}, now_s);
    for (const auto& [worker, done] : storing.repeated) {
        job.active->take_back(worker, claims_of(done));
        answer(worker, done.job, done.result, {wire::Verdict::already_merged, "particles of it are committed"}, now_s);
    }
}

void MasterCore::store_record(Job& job) {
    job.record_waits = false;
    ++job.records_on_their_way;
    effects_.push_back(StoreRecord{job.record, job.basis});
}

Effects MasterCore::on_record_stored(const StoreRecord& store, const Result<void>& stored, double now_s) {
    if (Job* job = find(store.record.id())) {
        --job->records_on_their_way;
        if (stored) {
            has_space(now_s);
            if (store.basis) job->basis.reset();
            answer_askers(*job);
        } else {
            // a solution brings its record along, and must not be followed by an older one
            job->record_waits =
                job->phase != Phase::storing && job->phase != Phase::removing && !job->record.has_solution;
            await_space(stored.error(), now_s);
        }
    }
    return settle_and_take(now_s);
}

void MasterCore::await_space(const Error& error, double now_s) {
    no_space_ = error.sentence;
    retry_s_ = now_s + limits::disk_retry_seconds;
}

void MasterCore::has_space(double now_s) {
    no_space_.reset();
    retry_s_ = now_s;  // what waits goes with the next tick
}

void MasterCore::try_again(double now_s) {
    if (now_s < retry_s_) return;
    bool waiting = false;
    for (auto& [id, job] : jobs_) {
        waiting = waiting || job.record_waits || job.solution_waits;
        if (job.record_waits) store_record(job);
        waiting = std::exchange(job.retraction_waits, false) || waiting;
        if (std::exchange(job.solution_waits, false)) effects_.push_back(StoreSolution{job.record, job.effort});
    }
    for (auto& [ticket, storing] : storing_) {
        if (!storing.waiting_for_space) continue;
        waiting = true;
        storing.waiting_for_space = false;
        effects_.push_back(StoreResult{ticket, storing.job, storing.machine, storing.result});
    }
    if (waiting) {
        retry_s_ = now_s + limits::disk_retry_seconds;
    } else {
        no_space_.reset();
    }
}

void MasterCore::store_snapshot(Job& job, double now_s) {
    if (job.lent || now_s < job.next_snapshot_s) return;
    job.snapshot_s = now_s;
    job.next_snapshot_s = std::numeric_limits<double>::infinity();
    effects_.push_back(StoreSnapshot{job.record.id(), effort_of(job, now_s), false, no_space_.has_value()});
}

/// One of a job with a million particles in flight may take seconds, while which no result is committed.
Effects MasterCore::on_snapshot_stored(const StoreSnapshot& store, double now_s) {
    Job* job = find(store.job);
    if (job && job->active) {
        const double took_s = now_s - job->snapshot_s;
        job->next_snapshot_s = std::max(job->snapshot_s + policy_.checkpoint_seconds, now_s + snapshot_pause * took_s);
    }
    return settle_and_take(now_s);
}

void MasterCore::collect_ended_leases() {
    StoreLeases leases;
    for (auto& [id, job] : jobs_) {
        if (!job.active) continue;
        const std::vector<LeaseId> ended = job.active->ledger().take_ended();
        leases.ended.insert(leases.ended.end(), ended.begin(), ended.end());
    }
    if (!leases.ended.empty()) effects_.push_back(std::move(leases));
}

}  // namespace lumenfarm
