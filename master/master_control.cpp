#include "master/master_core.h"

#include <algorithm>
#include <utility>

/// The master's core: what people do to a job. They are answered when it lasts.
namespace lumenfarm {

using wire::JobAction;
using wire::JobState;
using wire::RefusalReason;

namespace {

std::string name_of(const JobRecord& job) { return "job " + std::to_string(job.id()); }

std::string ended(const JobRecord& job) {
    switch (job.status.state) {
        case JobState::done: return name_of(job) + " is done";
        case JobState::cancelled: return name_of(job) + " was cancelled";
        default: return name_of(job) + " failed";
    }
}

}  // namespace

void MasterCore::on(SessionId session, std::uint64_t request_id, const wire::ControlRequest& request, double now_s) {
    Job* job = find(request.job);
    if (!job)
        return refuse(session, request_id, RefusalReason::no_such_job,
                      "there is no job " + std::to_string(request.job));
    if (job->askers.size() + job->late.size() >= limits::admissions_max)
        return refuse(session, request_id, RefusalReason::full, "the job is being changed; many wait for that");
    const bool ends = job->phase == Phase::storing && request.action != JobAction::cancel;
    if (job->phase == Phase::removing || (ends && job->solution_waits))
        return refuse(session, request_id, RefusalReason::not_ready,
                      name_of(job->record) + " is just ending; ask again in a moment");
    if (ends) {
        job->late.push_back({session, request_id, request});
        return;
    }
    if (const auto done = control(*job, request, now_s); !done)
        return refuse(session, request_id, RefusalReason::bad_request, done.error().sentence);
    job->askers.push_back({session, request_id, request.action});
    answer_askers(*job);
}

Result<void> MasterCore::control(Job& job, const wire::ControlRequest& request, double now_s) {
    switch (request.action) {
        case JobAction::pause: return pause(job, now_s);
        case JobAction::resume: return resume(job);
        case JobAction::cancel: cancel_job(job, now_s); return {};
        case JobAction::extend: return extend(job, request.particles, now_s);
        case JobAction::remove: return remove(job);
    }
    return {};
}

/// Once it lasts.
void MasterCore::answer_askers(Job& job) {
    const bool waits =
        job.records_on_their_way > 0 || job.record_waits || job.phase == Phase::storing || job.phase == Phase::removing;
    if (waits) return;
    const bool over = job.phase == Phase::over;
    for (const Asker& asker : std::exchange(job.askers, {})) {
        const bool ends = asker.action == JobAction::cancel && !over;
        send(asker.session, wire::ControlReply(job.record.id(), ends ? JobState::cancelled : job.record.status.state),
             asker.request_id);
    }
}

/// What was asked of the job while it ended is asked of it now.
void MasterCore::take_late_requests(Job& job, double now_s) {
    for (const LateRequest& late : std::exchange(job.late, {})) on(late.session, late.request_id, late.request, now_s);
}

/// No more sets; workers close their results of the job and hand back the rest.
void MasterCore::wind_up(Job& job, double now_s) {
    if (job.phase != Phase::running) return;
    job.phase = Phase::ending;
    job.end_by_s = now_s + limits::finish_seconds;
    for (auto& [id, session] : sessions_) {
        const Worker* worker = session.worker();
        if (worker && worker->told.contains(job.record.id())) send(id, wire::Drain(job.record.id()));
    }
    end_if_finished(job, now_s);
}

Result<void> MasterCore::pause(Job& job, double now_s) {
    JobRecord& record = job.record;
    if (record.over()) return bad_input(ended(record) + "; there is nothing to pause");
    if (record.cancel_asked) return bad_input(name_of(record) + " is being cancelled");
    if (record.paused) return {};
    record.paused = true;
    record.status.state = JobState::paused;
    store_record(job);
    if (job.phase == Phase::queued) tell_gone(job);  // who holds results for it waits no longer
    wind_up(job, now_s);
    return {};
}

/// Nothing is left but sets that would kill more workers: somebody has to look.
void MasterCore::pause_if_stuck(Job& job, double now_s) {
    if (job.lent || job.phase != Phase::running || !job.active->ledger().only_set_aside_left()) return;
    if (!job.active->ledger().retry_set_aside(now_s)) (void)pause(job, now_s);
}

Result<void> MasterCore::resume(Job& job) {
    JobRecord& record = job.record;
    if (record.over()) return bad_input(ended(record) + "; `extend` gives it more particles");
    if (!record.paused) return {};
    record.paused = false;
    record.status.state = JobState::queued;
    record.status.set_aside.clear();
    record.status.sentence.clear();
    store_record(job);
    return {};
}

Effects MasterCore::cancel(JobId id, double now_s) {
    if (Job* job = find(id)) cancel_job(*job, now_s);
    return settle_and_take(now_s);
}

void MasterCore::cancel_job(Job& job, double now_s) {
    JobRecord& record = job.record;
    if (record.over() || record.cancel_asked || job.phase == Phase::storing) return;
    const bool begins = job.phase == Phase::queued || job.phase == Phase::preparing;
    const bool given_up = is_held_back(record);
    record.paused = false;
    record.status.sentence.clear();
    if (begins && (!record.begun || given_up)) {
        job.phase = Phase::over;
        record.status.state = JobState::cancelled;
        record.ended_unix_seconds = unix_seconds(now_s);
        store_record(job);
        return tell_gone(job);
    }
    // what was committed is kept: a job that does not run ends when that is read
    record.cancel_asked = true;
    record.status.state = JobState::running;
    store_record(job);
    if (job.phase == Phase::running && drains(job))
        begin_draining(job, now_s);
    else
        wind_up(job, now_s);
    end_if_finished(job, now_s);
}

/// A job that has begun goes on from what it has: that is prepared anew, with more particles to each light.
Result<void> MasterCore::extend(Job& job, std::uint64_t particles, double now_s) {
    JobRecord& record = job.record;
    if (record.status.state == JobState::failed) return bad_input(ended(record) + "; submit it again");
    JobSpec spec = record.spec;
    spec.particles = particles;
    if (const auto good = validate(spec); !good) return good.error();
    if (particles < record.spec.particles)
        return bad_input(name_of(record) + " has " + std::to_string(record.spec.particles) +
                         " particles; it can be extended to more, not to " + std::to_string(particles));
    if (particles == record.spec.particles && !record.cancel_asked &&
        (!record.over() || record.status.state == JobState::done))
        return {};
    record.spec = spec;
    record.status.particles = particles;
    record.cancel_asked = false;
    job.gives_flights_up = false;
    if (record.over()) {
        // without what was in flight a solution is no part of a larger one
        const bool goes_on = record.has_solution && !record.flights_lost;
        if (goes_on) job.basis = record.solution_file;
        record.audited = false;  // of what is in the solution no single result is kept
        job.phase = Phase::queued;
        record.begun = goes_on;
        record.has_solution = record.complete = record.flights_lost = false;
        record.status.state = JobState::queued;
        record.status.digest.reset();
        record.ended_unix_seconds = 0;
        store_record(job);
        return {};
    }
    job.resumes = record.begun && !record.paused;
    store_record(job);
    wind_up(job, now_s);
    return {};
}

Result<void> MasterCore::remove(Job& job) {
    const JobRecord& record = job.record;
    if (!record.over()) return bad_input(name_of(record) + " is not over; cancel it first");
    std::vector<Digest> files{record.status.scene};
    if (record.has_solution) files.push_back(record.solution_file);
    std::erase_if(files, [&](const Digest& file) {
        return std::any_of(jobs_.begin(), jobs_.end(),
                           [&](const auto& entry) {
                               const JobRecord& other = entry.second.record;
                               return entry.first != record.id() &&
                                      (other.status.scene == file ||
                                       (other.has_solution && other.solution_file == file) ||
                                       entry.second.basis == file);
                           }) ||
               std::any_of(admissions_.begin(), admissions_.end(),
                           [&](const Admit& admit) { return admit.submit.scene.file == file; });
    });
    job.phase = Phase::removing;
    job.record_waits = false;
    effects_.push_back(RemoveJob{record.id(), std::move(files)});
    return {};
}

Effects MasterCore::on_removed(const RemoveJob& removal, const Result<void>& removed, double now_s) {
    Job* job = find(removal.job);
    if (!job || job->phase != Phase::removing) return settle_and_take(now_s);
    job->phase = Phase::over;
    if (removed) {
        answer_askers(*job);
        jobs_.erase(removal.job);
    } else {
        for (const Asker& asker : std::exchange(job->askers, {}))
            refuse(asker.session, asker.request_id, RefusalReason::failed, removed.error().sentence);
        await_space(removed.error(), now_s);
    }
    return settle_and_take(now_s);
}

/// By age; by size from the one that ended first, but never the last result. One at a time.
void MasterCore::remove_old_jobs(double now_s) {
    if (no_space_) return;
    Job* oldest = nullptr;
    Job* oldest_result = nullptr;
    std::uint64_t bytes = 0, results = 0;
    const auto older = [](const Job& job, const Job* than) {
        return !than || job.record.ended_unix_seconds < than->record.ended_unix_seconds;
    };
    for (auto& [id, job] : jobs_) {
        if (job.phase == Phase::removing) return;
        if (job.phase != Phase::over || job.records_on_their_way > 0 || job.record_waits) continue;
        if (older(job, oldest)) oldest = &job;
        if (!job.record.has_solution) continue;
        bytes += job.record.solution_bytes;
        ++results;
        if (older(job, oldest_result)) oldest_result = &job;
    }
    const auto age_s = [&] { return static_cast<double>(unix_seconds(now_s) - oldest->record.ended_unix_seconds); };
    if (policy_.keep_bytes && bytes > *policy_.keep_bytes && results > 1) return (void)remove(*oldest_result);
    if (policy_.keep_seconds && oldest && age_s() > *policy_.keep_seconds) (void)remove(*oldest);
}

}  // namespace lumenfarm
