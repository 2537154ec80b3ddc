#include "master/master_core.h"

#include <algorithm>
#include <utility>

/// The master's core: the queue, and the way of a job from queued to over.
namespace lumenfarm {

namespace {

constexpr double rate_window_s = 10;  ///< over which a job's rate is measured

}  // namespace

void MasterCore::restore(JobRecord record) {
    next_job_ = std::max(next_job_, record.id() + 1);
    Job job;
    job.record = std::move(record);
    if (job.record.over()) {
        job.phase = Phase::over;
    } else {
        job.resumes = job.record.status.state == wire::JobState::running && !job.record.paused;
        job.record.status.state = job.record.paused ? wire::JobState::paused : wire::JobState::queued;
    }
    jobs_.insert_or_assign(job.record.id(), std::move(job));
}

MasterCore::Job* MasterCore::find(JobId job) {
    const auto found = jobs_.find(job);
    return found == jobs_.end() ? nullptr : &found->second;
}

const JobRecord* MasterCore::record(JobId job) const {
    const auto found = jobs_.find(job);
    return found == jobs_.end() ? nullptr : &found->second.record;
}

const Ledger* MasterCore::ledger(JobId job) const {
    const auto found = jobs_.find(job);
    return found == jobs_.end() || !found->second.active ? nullptr : &found->second.active->ledger();
}

/// By priority, then age.
bool MasterCore::before(const Job& a, const Job& b) {
    if (a.record.spec.priority != b.record.spec.priority) return a.record.spec.priority > b.record.spec.priority;
    return a.record.id() < b.record.id();
}

std::vector<MasterCore::Job*> MasterCore::running_in_order() {
    std::vector<Job*> running;
    for (auto& [id, job] : jobs_)
        if (job.phase == Phase::running) running.push_back(&job);
    std::sort(running.begin(), running.end(), [](const Job* a, const Job* b) { return before(*a, *b); });
    return running;
}

/// True when a worker holds results of the job, and waits for it.
bool MasterCore::is_awaited(JobId job) const {
    return std::any_of(sessions_.begin(), sessions_.end(), [&](const auto& entry) {
        return entry.second.worker() && entry.second.worker()->awaited.contains(job);
    });
}

/// Jobs of one priority share the farm; those of a lower one begin when nothing is left to lease of the others. Jobs
/// whose results workers hold, and those that are only to be ended, come first.
MasterCore::Job* MasterCore::next_to_prepare() {
    Job* next = nullptr;
    const auto is_first = [&](const Job& job) {
        return job.resumes || job.record.cancel_asked || is_awaited(job.record.id());
    };
    for (auto& [id, job] : jobs_) {
        if (!job.may_begin()) continue;
        if (!next || (is_first(job) == is_first(*next) ? before(job, *next) : is_first(job))) next = &job;
    }
    if (!next || is_first(*next)) return next;
    for (const auto& [id, job] : jobs_)
        if (job.phase == Phase::running && job.record.spec.priority > next->record.spec.priority &&
            job.active->ledger().unleased() > 0 && !nobody_can_trace(job))
            return nullptr;
    return next;
}

void MasterCore::prepare_next(double now_s) {
    if (no_space_) return;
    std::size_t active = 0;
    Job* lowest = nullptr;
    for (auto& [id, job] : jobs_) {
        if (job.phase == Phase::preparing) return;
        active += job.active != nullptr || job.phase == Phase::storing || job.phase == Phase::put_aside;
        if (job.phase == Phase::running && (!lowest || before(*lowest, job))) lowest = &job;
    }
    Job* next = next_to_prepare();
    if (!next) return;
    if (active < limits::active_jobs_max) {
        next->phase = Phase::preparing;
        if (!next->record.begun)
            next->record.audited = policy_.audit_fraction > 0 && next->record.spec.strategy == Strategy::sets;
        return effects_.push_back(Prepare{next->record, policy_.recut_above, policy_.recut_hits});
    }
    // the least of those that run makes room for one that should go before it; one at a time
    const bool goes_before = lowest && std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& entry) {
                                 const JobRecord& record = entry.second.record;
                                 return entry.second.may_begin() &&
                                        (record.cancel_asked || record.spec.priority > lowest->record.spec.priority);
                             });
    const bool one_ends = std::any_of(jobs_.begin(), jobs_.end(), [](const auto& entry) {
        const Phase phase = entry.second.phase;
        return phase == Phase::ending || phase == Phase::put_aside || phase == Phase::storing;
    });
    if (goes_before && !one_ends && active == limits::active_jobs_max) wind_up(*lowest, now_s);
}

Effects MasterCore::on_prepared(JobId id, Result<RecoveredJob> recovered, double now_s) {
    Job* job = find(id);
    if (!job || job->phase != Phase::preparing) return settle_and_take(now_s);
    JobRecord& record = job->record;
    if (!recovered) {
        not_prepared(*job, recovered.error(), now_s);
        return settle_and_take(now_s);
    }
    // that they ended may not be on the disk yet
    bool void_leases = job->was_put_aside || record.distrusted;
    // what was lost may have lowered the threshold that they were given with
    void_leases |= !recovered->damages.empty() && record.spec.keep_hits > 0;
    // flights may have other numbers now
    void_leases |= !recovered->damages.empty() && recovered->prepared->subspaces.has_value();
    void_leases |= recovered->recut.has_value();
    if (void_leases) {
        StoreLeases ended;
        for (const GivenLease& lease : std::exchange(recovered->leases, {})) ended.ended.push_back(lease.lease);
        if (!ended.ended.empty()) effects_.push_back(std::move(ended));
    }
    for (const std::string& damage : recovered->damages)
        count(Discard::stored_result_damaged, 1, damage + "; its particles are traced again");
    job->active =
        std::make_unique<ActiveJob>(record.spec, std::move(*recovered), now_s, now_s + limits::restart_seconds);
    const bool extended = job->active->ledger().particles() != record.spec.particles;
    const bool ends = record.paused || extended || (record.cancel_asked && !drains(*job));
    job->phase = ends ? Phase::ending : Phase::running;
    job->end_by_s = now_s + limits::finish_seconds;
    if (!ends && drains(*job)) begin_draining(*job, now_s);
    job->snapshot_s = job->measured_s = now_s;
    job->next_snapshot_s = now_s + policy_.checkpoint_seconds;
    job->resumes = false;
    record.status.set_aside.clear();
    record.status.sentence.clear();
    if (!record.paused) record.status.state = wire::JobState::running;
    // what was said of results of another packing can't be compared
    if (record.begun && record.status.packing != job->active->packing())
        count(Discard::audit_hopeless, audits_.drop(id), "the job is packed in another way now");
    record.status.packing = job->active->packing();
    if (!record.begun) {
        record.begun = true;
        store_record(*job);
    }
    resume_workers(*job, now_s);
    end_if_finished(*job, now_s);
    return settle_and_take(now_s);
}

/// Workers that came back while the job was being prepared go on with what they hold of it.
void MasterCore::resume_workers(Job& job, double now_s) {
    Ledger& ledger = job.active->ledger();
    for (auto& [id, session] : sessions_) {
        Worker* worker = session.worker();
        if (!worker || !worker->leases_stated) continue;
        release_forgotten(session, job);
        ledger.extend(session.instance(), now_s + limits::lease_seconds);
        if (worker->awaited.erase(job.record.id()) > 0) tell(session, *worker, job);
    }
}

void MasterCore::end_if_finished(Job& job, double now_s) {
    if (job.lent) return;
    if (job.phase != Phase::running && job.phase != Phase::ending) return;
    if (job.results_on_their_way > 0) return;
    const Ledger& ledger = job.active->ledger();
    const bool drained = drains(job) && has_drained(job);
    const bool waited = (drained && job.phase == Phase::running) ||
                        (job.phase == Phase::ending && (ledger.outstanding() == 0 || now_s >= job.end_by_s));
    // nobody waits for audits in an end; where two already contradict each other that is decided when the job goes on
    if (waited) count(Discard::audit_hopeless, audits_.drop_undisputed(job.record.id()), "the job was interrupted");
    if (waited && job.record.cancel_asked)
        count(Discard::audit_hopeless, audits_.drop(job.record.id()),
              "the job was cancelled in the midst of a dispute");
    const bool extended = ledger.particles() != job.record.spec.particles;  // since it was prepared
    const bool whole = ledger.complete() && !extended;
    if (has_liars(job)) return;
    // what is in flight is followed first, in a next run of the job if need be
    const bool may_end = job.record.cancel_asked && !extended && (!drains(job) || drained || job.gives_flights_up);
    if ((whole && !is_questioned(job)) || (waited && may_end)) return end_with_solution(job, now_s);
    if (waited) put_aside(job, now_s);
}

void MasterCore::end_with_solution(Job& job, double now_s) {
    JobRecord& record = job.record;
    record.complete = job.active->ledger().complete();
    record.flights_lost = job.active->ledger().in_flight() > 0;
    record.paused = false;  // the last results came while it was being paused
    record.status = counts_of(job, now_s);
    record.status.leased = 0;
    record.status.workers = 0;
    record.status.eta_seconds.reset();
    record.ended_unix_seconds = unix_seconds(now_s);
    job.phase = Phase::storing;
    job.record_waits = false;
    job.effort = effort_of(job, now_s);
    effects_.push_back(StoreSolution{record, job.effort});
    end_activity(job);
}

/// It may begin again: when it is resumed, or extended.
void MasterCore::end_activity(Job& job) {
    job.active.reset();
    job.started_s.reset();
    job.contributors.clear();
    job.committed_at.clear();
    tell_gone(job);
}

/// Until it goes on: when it is resumed, at once with more particles, or when there is room for it again.
void MasterCore::put_aside(Job& job, double now_s) {
    job.active->ledger().release_all();
    collect_ended_leases();
    job.record.status = counts_of(job, now_s);
    job.record.status.leased = 0;
    job.record.status.workers = 0;
    job.record.status.particles_per_second = 0;
    job.record.status.eta_seconds.reset();
    // one that makes room for others does not come before them after a restart
    if (!job.record.paused && !job.resumes) job.record.status.state = wire::JobState::queued;
    job.phase = Phase::put_aside;
    job.was_put_aside = true;
    audits_.interrupt(job.record.id(), now_s);
    store_record(job);
    effects_.push_back(PutAside{job.record.id(), effort_of(job, now_s)});
    end_activity(job);
}

Effects MasterCore::on_put_aside(const PutAside& aside, double now_s) {
    Job* job = find(aside.job);
    if (!job || job->phase != Phase::put_aside) return settle_and_take(now_s);
    job->phase = Phase::queued;
    if (!job->record.paused) job->record.status.state = wire::JobState::queued;
    answer_askers(*job);
    return settle_and_take(now_s);
}

Effects MasterCore::on_solution_stored(const StoreSolution& store, const Result<JobRecord>& stored, double now_s) {
    Job* job = find(store.record.id());
    if (!job || job->phase != Phase::storing) return settle_and_take(now_s);
    if (stored) {
        job->phase = Phase::over;
        job->record = *stored;
        answer_askers(*job);
    } else {
        job->solution_waits = true;
        await_space(stored.error(), now_s);
    }
    take_late_requests(*job, now_s);
    return settle_and_take(now_s);
}

void MasterCore::end_with_failure(Job& job, std::string sentence, double now_s) {
    job.phase = Phase::over;
    job.record.status.state = wire::JobState::failed;
    job.record.ended_unix_seconds = unix_seconds(now_s);
    job.record.status.sentence = std::move(sentence);
    audits_.drop(job.record.id());
    store_record(job);
    tell_gone(job);
}

/// What it has on the disk, or may have, is not given up because something can't be read now.
void MasterCore::not_prepared(Job& job, const Error& error, double now_s) {
    if (error.code == ErrorCode::no_space) {
        job.phase = Phase::queued;
        return await_space(error, now_s);
    }
    if (error.code == ErrorCode::bad_input && !job.record.begun) return end_with_failure(job, error.sentence, now_s);
    job.phase = Phase::queued;
    job.resumes = false;
    job.record.paused = true;
    job.record.cancel_asked = false;
    job.record.status.state = wire::JobState::paused;
    job.record.status.sentence = error.sentence;
    store_record(job);
    tell_gone(job);
}

void MasterCore::tell_gone(Job& job) {
    for (auto& [id, session] : sessions_) {
        Worker* worker = session.worker();
        if (!worker) continue;
        worker->declined.erase(job.record.id());
        worker->paces.erase(job.record.id());
        worker->parts.erase(job.record.id());
        std::erase_if(worker->held, [&](const auto& lease) { return lease.second == job.record.id(); });
        const std::size_t knew = worker->told.erase(job.record.id()) + worker->awaited.erase(job.record.id());
        if (knew > 0) send(id, wire::JobGone(job.record.id()));
    }
}

/// Particles of lights. In the ledger of a lent job those that are not lent count as committed.
std::uint64_t MasterCore::traced(const Job& job) {
    return job.lent ? job.active->balance().particles : job.active->ledger().committed_particles();
}

void MasterCore::sample_rate(Job& job, double now_s) const {
    auto& samples = job.committed_at;
    samples.emplace_back(now_s, traced(job));
    const auto recent = std::find_if(samples.begin(), samples.end(),
                                     [&](const auto& sample) { return sample.first >= now_s - rate_window_s; });
    samples.erase(samples.begin(), recent);
}

JobEffort MasterCore::effort_of(const Job& job, double now_s) const {
    JobEffort effort = job.active->earlier_effort();
    if (job.started_s) effort.elapsed_s += now_s - *job.started_s;
    effort.workers = std::max(effort.workers, static_cast<std::uint32_t>(job.contributors.size()));
    return effort;
}

wire::JobStatus MasterCore::status_of(const Job& job, double now_s) const {
    wire::JobStatus status = counts_of(job, now_s);
    if (!job.record.over()) status.sentence = why(job, now_s);
    return status;
}

wire::JobStatus MasterCore::counts_of(const Job& job, double now_s) const {
    wire::JobStatus status = job.record.status;
    if (!job.active) return status;
    const Ledger& ledger = job.active->ledger();
    status.committed = traced(job);
    status.leased = ledger.leased_particles();
    if (const auto& aside = ledger.lost().set_aside(); !aside.empty()) {
        status.set_aside.clear();
        for (std::size_t i = 0; i < std::min<std::size_t>(aside.size(), limits::set_aside_listed_max); ++i)
            status.set_aside.push_back(aside[i].range);
    }
    status.hits = job.active->balance().hits;
    status.workers = static_cast<std::uint32_t>(ledger.workers());
    status.trace_seconds = job.active->trace_cpu_s();
    status.elapsed_seconds = effort_of(job, now_s).elapsed_s;
    const auto [since_s, before] =
        job.committed_at.empty() ? std::pair(now_s, status.committed) : job.committed_at.front();
    if (now_s > since_s)
        status.particles_per_second = static_cast<double>(status.committed - before) / (now_s - since_s);
    if (status.particles_per_second > 0 && !job.lent)
        status.eta_seconds = static_cast<double>(ledger.particles() - status.committed) / status.particles_per_second;
    return status;
}

std::optional<wire::JobStatus> MasterCore::status(JobId id, double now_s) const {
    const auto found = jobs_.find(id);
    if (found == jobs_.end()) return std::nullopt;
    return status_of(found->second, now_s);
}

}  // namespace lumenfarm
