#include "master/master_core.h"

#include <algorithm>
#include <utility>

/// The master's core: the queue, and the way of a job from queued to over.
namespace lumenfarm {

namespace {

constexpr double rate_window_s = 10;  ///< over which a job's rate is measured

}  // namespace

Effects MasterCore::restore(JobRecord record) {
    next_job_ = std::max(next_job_, record.id() + 1);
    Job job;
    job.record = std::move(record);
    if (job.record.over()) {
        job.phase = Phase::over;
    } else {
        job.record.status.state = wire::JobState::queued;
    }
    jobs_.insert_or_assign(job.record.id(), std::move(job));
    return std::exchange(effects_, {});
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

/// One job at a time: the next begins when those before it have nothing left to lease.
void MasterCore::prepare_next() {
    Job* next = nullptr;
    std::size_t active = 0;
    for (auto& [id, job] : jobs_) {
        if (job.phase == Phase::preparing) return;
        active += job.active != nullptr;
        if (job.phase == Phase::queued && (!next || before(job, *next))) next = &job;
    }
    if (!next || active >= limits::active_jobs_max) return;
    for (const auto& [id, job] : jobs_)
        if (job.phase == Phase::running && before(job, *next) && job.active->ledger().unleased() > 0) return;
    next->phase = Phase::preparing;
    effects_.push_back(Prepare{next->record.id(), next->record.spec, next->record.status.scene});
}

Effects MasterCore::on_prepared(JobId id, Result<std::shared_ptr<const PreparedJob>> prepared, double now_s) {
    Job* job = find(id);
    if (job && job->phase == Phase::preparing) {
        if (!prepared) {
            end_with_failure(*job, prepared.error().sentence);
        } else {
            job->active = std::make_unique<ActiveJob>(job->record.spec, std::move(*prepared));
            job->phase = Phase::running;
            job->record.status.state = wire::JobState::running;
            job->record.status.packing = job->active->packing();
        }
    }
    return settle_and_take(now_s);
}

void MasterCore::end_if_finished(Job& job, double now_s) {
    if (job.phase != Phase::running && job.phase != Phase::ending) return;
    const Ledger& ledger = job.active->ledger();
    const bool waited = job.phase == Phase::ending && (ledger.outstanding() == 0 || now_s >= job.end_by_s);
    if (!ledger.complete() && !waited) return;
    JobRecord& record = job.record;
    record.complete = ledger.complete();
    record.status = status_of(job, now_s);
    record.status.leased = 0;
    record.status.workers = 0;
    record.status.eta_seconds.reset();
    job.phase = Phase::storing;
    const double total_s = record.status.elapsed_seconds;
    auto solution =
        job.active->take_solution(record.status.scene, static_cast<std::uint32_t>(job.contributors.size()), total_s);
    effects_.push_back(StoreSolution{record.id(), std::move(solution)});
    job.active.reset();
    tell_gone(job);
}

Effects MasterCore::on_solution_stored(JobId id, const Result<StoredSolution>& stored, double now_s) {
    Job* job = find(id);
    if (job && job->phase == Phase::storing) {
        JobRecord& record = job->record;
        if (!stored) {
            end_with_failure(*job, stored.error().sentence);
        } else {
            job->phase = Phase::over;
            record.status.state = record.complete ? wire::JobState::done : wire::JobState::cancelled;
            record.status.digest = stored->digest;
            record.solution_file = stored->file;
            record.has_solution = true;
            effects_.push_back(StoreRecord{record});
        }
    }
    return settle_and_take(now_s);
}

void MasterCore::end_with_failure(Job& job, std::string sentence) {
    job.phase = Phase::over;
    job.record.status.state = wire::JobState::failed;
    job.record.status.sentence = std::move(sentence);
    effects_.push_back(StoreRecord{job.record});
}

void MasterCore::tell_gone(Job& job) {
    for (auto& [id, session] : sessions_) {
        Worker* worker = session.worker();
        if (!worker) continue;
        worker->declined.erase(job.record.id());
        if (worker->told.erase(job.record.id()) > 0) send(id, wire::JobGone(job.record.id()));
    }
}

Effects MasterCore::cancel(JobId id, double now_s) {
    if (Job* job = find(id)) cancel_job(*job, now_s);
    return settle_and_take(now_s);
}

void MasterCore::cancel_job(Job& job, double now_s) {
    if (job.phase == Phase::queued || job.phase == Phase::preparing) {
        job.phase = Phase::over;
        job.record.status.state = wire::JobState::cancelled;
        effects_.push_back(StoreRecord{job.record});
        return;
    }
    if (job.phase != Phase::running) return;
    job.phase = Phase::ending;
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

wire::JobStatus MasterCore::status_of(const Job& job, double now_s) const {
    wire::JobStatus status = job.record.status;
    if (!job.active) return status;
    const Ledger& ledger = job.active->ledger();
    status.committed = ledger.committed_particles();
    status.leased = ledger.particles() - ledger.unleased() - status.committed;
    status.hits = job.active->balance().hits;
    status.workers = static_cast<std::uint32_t>(ledger.workers());
    status.trace_seconds = job.active->trace_s();
    status.elapsed_seconds = job.started_s ? now_s - *job.started_s : 0;
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
