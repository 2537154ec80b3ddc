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
        job.resumes = job.record.status.state == wire::JobState::running;
        job.record.status.state = wire::JobState::queued;
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

/// One job at a time: the next begins when those before it have nothing left to lease. Jobs that were running when an
/// earlier life ended come first, since workers hold results of them.
MasterCore::Job* MasterCore::next_to_prepare() {
    Job* next = nullptr;
    bool next_is_awaited = false;
    for (auto& [id, job] : jobs_) {
        if (job.phase != Phase::queued) continue;
        const bool awaited = job.resumes || is_awaited(id);
        if (next && (awaited != next_is_awaited ? next_is_awaited : !before(job, *next))) continue;
        next = &job;
        next_is_awaited = awaited;
    }
    if (!next || next_is_awaited) return next;
    for (const auto& [id, job] : jobs_)
        if (job.phase == Phase::running && before(job, *next) && job.active->ledger().unleased() > 0) return nullptr;
    return next;
}

void MasterCore::prepare_next() {
    std::size_t active = 0;
    for (auto& [id, job] : jobs_) {
        if (job.phase == Phase::preparing) return;
        active += job.active != nullptr || job.phase == Phase::storing;
    }
    Job* next = next_to_prepare();
    if (!next || active >= limits::active_jobs_max) return;
    next->phase = Phase::preparing;
    effects_.push_back(Prepare{next->record});
}

Effects MasterCore::on_prepared(JobId id, Result<RecoveredJob> recovered, double now_s) {
    Job* job = find(id);
    if (!job || job->phase != Phase::preparing) return settle_and_take(now_s);
    JobRecord& record = job->record;
    if (!recovered) {
        end_with_failure(*job, recovered.error().sentence);
        return settle_and_take(now_s);
    }
    for (const std::string& damage : recovered->damages)
        count(Discard::stored_result_damaged, 1, damage + "; its particles are traced again");
    job->active =
        std::make_unique<ActiveJob>(record.spec, std::move(*recovered), now_s, now_s + limits::restart_seconds);
    job->phase = record.cancel_asked ? Phase::ending : Phase::running;
    job->end_by_s = now_s + limits::finish_seconds;
    job->snapshot_s = now_s;
    record.status.state = wire::JobState::running;
    record.status.packing = job->active->packing();
    if (!job->resumes) store_record(*job);
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
    if (job.phase != Phase::running && job.phase != Phase::ending) return;
    if (job.results_on_their_way > 0) return;
    const Ledger& ledger = job.active->ledger();
    const bool waited = job.phase == Phase::ending && (ledger.outstanding() == 0 || now_s >= job.end_by_s);
    if (!ledger.complete() && !waited) return;
    JobRecord& record = job.record;
    record.complete = ledger.complete();
    record.status = status_of(job, now_s);
    record.status.sentence.clear();
    record.status.leased = 0;
    record.status.workers = 0;
    record.status.eta_seconds.reset();
    job.phase = Phase::storing;
    job.record_waits = false;
    job.effort = effort_of(job, now_s);
    effects_.push_back(StoreSolution{record, job.effort});
    job.active.reset();
    tell_gone(job);
}

Effects MasterCore::on_solution_stored(const StoreSolution& store, const Result<JobRecord>& stored, double now_s) {
    Job* job = find(store.record.id());
    if (!job || job->phase != Phase::storing) return settle_and_take(now_s);
    if (stored) {
        job->phase = Phase::over;
        job->record = *stored;
        answer_cancel(*job);
    } else {
        job->solution_waits = true;
        await_space(stored.error(), now_s);
    }
    return settle_and_take(now_s);
}

void MasterCore::end_with_failure(Job& job, std::string sentence) {
    job.phase = Phase::over;
    job.record.status.state = wire::JobState::failed;
    job.record.status.sentence = std::move(sentence);
    store_record(job);
    tell_gone(job);
}

void MasterCore::tell_gone(Job& job) {
    for (auto& [id, session] : sessions_) {
        Worker* worker = session.worker();
        if (!worker) continue;
        worker->declined.erase(job.record.id());
        const std::size_t knew = worker->told.erase(job.record.id()) + worker->awaited.erase(job.record.id());
        if (knew > 0) send(id, wire::JobGone(job.record.id()));
    }
}

Effects MasterCore::cancel(JobId id, double now_s) {
    if (Job* job = find(id)) cancel_job(*job, now_s);
    return settle_and_take(now_s);
}

void MasterCore::cancel_job(Job& job, double now_s) {
    const bool begins = job.phase == Phase::queued || job.phase == Phase::preparing;
    if (begins && job.resumes) {
        // what earlier lives have committed is kept: it ends when that is read
        job.record.cancel_asked = true;
        job.record.status.state = wire::JobState::running;
        return store_record(job);
    }
    if (begins) {
        job.phase = Phase::over;
        job.record.status.state = wire::JobState::cancelled;
        store_record(job);
        tell_gone(job);
        return;
    }
    if (job.phase != Phase::running) return;
    job.phase = Phase::ending;
    job.record.cancel_asked = true;
    store_record(job);
    job.end_by_s = now_s + limits::finish_seconds;
    for (auto& [id, session] : sessions_) {
        const Worker* worker = session.worker();
        if (worker && worker->told.contains(job.record.id())) send(id, wire::Drain(job.record.id()));
    }
    end_if_finished(job, now_s);
}

void MasterCore::sample_rate(Job& job, double now_s) const {
    auto& samples = job.committed_at;
    samples.emplace_back(now_s, job.active->ledger().committed_particles());
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
    wire::JobStatus status = job.record.status;
    if (no_space_ && (job.active || job.phase == Phase::storing)) status.sentence = *no_space_;
    if (!job.active) return status;
    const Ledger& ledger = job.active->ledger();
    status.committed = ledger.committed_particles();
    status.leased = ledger.particles() - ledger.unleased() - status.committed;
    status.hits = job.active->balance().hits;
    status.workers = static_cast<std::uint32_t>(ledger.workers());
    status.trace_seconds = job.active->trace_s();
    status.elapsed_seconds = effort_of(job, now_s).elapsed_s;
    const auto [since_s, before] =
        job.committed_at.empty() ? std::pair(now_s, status.committed) : job.committed_at.front();
    if (now_s > since_s)
        status.particles_per_second = static_cast<double>(status.committed - before) / (now_s - since_s);
    if (status.particles_per_second > 0)
        status.eta_seconds = static_cast<double>(ledger.particles() - status.committed) / status.particles_per_second;
    return status;
}

std::optional<wire::JobStatus> MasterCore::status(JobId id, double now_s) const {
    const auto found = jobs_.find(id);
    if (found == jobs_.end()) return std::nullopt;
    return status_of(found->second, now_s);
}

}  // namespace lumenfarm
