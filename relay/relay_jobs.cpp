#include "relay/relay_core.h"

#include <algorithm>
#include <utility>

/// The relay's core: jobs of the master above, and the sets that it lends.
namespace lumenfarm::relay {

using wire::ReturnReason;
using worker::Discard;

/// States what is still held, before anything is pulled.
void RelayCore::greet(const wire::Welcome& welcome, double now_s) {
    welcome_ = true;
    wished_ = {};
    leases_received_ = 0;
    credit_ = welcome.results_in_flight;
    // after this long the master above has given the leases to others
    if (lost_s_ && now_s - *lost_s_ > welcome.reconnect_seconds) {
        for (auto& [id, job] : jobs_) {
            count(Discard::set_outlived, job.sets.all().size() + job.waiting.size(),
                  "the master was away for too long");
            // of a lease that another result claims, and states, the master waits for the rest until it is told
            if (job.open) leave(job, job.open->claims());
            give_all_back(job, ReturnReason::ending);
        }
    }
    lost_s_.reset();
    // what results still claim is stated, and goes back after them
    returns_.keep_only([&](std::uint64_t lease) { return claimed(lease); });
    send(wire::Progress(0, leases_held()));
    drop_jobs_not_held(now_s);
    if (!fetch_) return;
    for (wire::Message& request : fetch_->begin_session()) send(std::move(request));
}

std::vector<wire::LeaseProgress> RelayCore::leases_held() const {
    std::map<std::uint64_t, JobId> job_by_lease = results_.leases();
    for (const auto& [id, job] : jobs_) {
        for (const wire::Lease& lease : job.waiting) job_by_lease.emplace(lease.lease, id);
        for (const LentSet& set : job.sets.all()) job_by_lease.emplace(set.lease, id);
        if (!job.open) continue;
        for (const wire::Claim& claim : job.open->claims()) job_by_lease.emplace(claim.lease, id);
    }
    std::vector<wire::LeaseProgress> held;
    for (const auto& [lease, job] : job_by_lease)
        if (held.size() < limits::leases_per_worker_max) held.emplace_back(job, lease, 0);
    return held;
}

void RelayCore::take_job(const wire::JobInfo& info, double now_s) {
    if (const auto known = jobs_.find(info.job); known != jobs_.end()) {
        const bool same = known->second.info.scene == info.scene && known->second.info.spec == info.spec;
        if (same && known->second.phase != Phase::failed) {
            known->second.confirmed = true;
            return;
        }
        // the job is another one now: what this relay has of it is nobody's
        for (const wire::LeaseProgress& lease : leases_held())
            if (lease.job == info.job) returns_.add(ReturnReason::ending, lease.lease, epoch_of(lease.lease));
        drop_job(info.job, now_s);
    }
    Job& job = jobs_[info.job];
    job.info = info;
    job.confirmed = true;
    job.files.emplace(info.scene, info.scene_bytes);
    need(job, info.scene);
}

void RelayCore::take_lease(wire::Lease lease) {
    ++leases_received_;
    if (wished_.sets > 0) --wished_.sets;
    wished_.leases = leases_received_;
    const auto job = jobs_.find(lease.job);
    const bool failed = job != jobs_.end() && job->second.phase == Phase::failed;
    // a result of an audit is of one worker
    const bool unwanted = job == jobs_.end() || failed || drain_by_s_ || lease.audit != 0;
    if (unwanted) return returns_.add(failed ? ReturnReason::no_scene : ReturnReason::ending, lease.lease, lease.epoch);
    // a job that was drained goes on
    if (std::exchange(job->second.drain_by_s, std::nullopt) && job->second.phase == Phase::running)
        farm_.resume_lent(lease.job);
    if (job->second.phase == Phase::running) return lend(job->second, std::move(lease));
    job->second.waiting.push_back(std::move(lease));
}

void RelayCore::lend(Job& job, wire::Lease lease) {
    const PreparedJob& prepared = job.open->prepared();
    const bool of_light = lease.range.source < prepared.particles.size();
    const bool possible =
        lease.range.source < prepared.sources() && lease.flights.size() == (of_light ? 0 : lease.range.count);
    if (!possible) {
        count(Discard::set_not_traceable, 1, "a set of job " + std::to_string(lease.job) + " is impossible");
        return returns_.add(ReturnReason::tracer_failed, lease.lease, lease.epoch);
    }
    // of an older lease for them, or of its number, the master does not know any more
    std::vector<wire::Claim> older;
    for (const LentSet& set : job.sets.in_the_way_of(lease)) older.emplace_back(set.lease, set.epoch, set.range);
    if (!older.empty()) leave(job, older);
    // some of them may be in a result that waits for room
    if (!farm_.lend(lease.job, lease.range, std::move(lease.flights), lease.keep_threshold))
        return returns_.add(ReturnReason::ending, lease.lease, lease.epoch);
    job.sets.add(lease);
}

Effects RelayCore::on_prepared(const wire::JobInfo& info, Result<Preparation> prepared, double now_s) {
    const auto found = jobs_.find(info.job);
    // what was prepared for an earlier job of that number is of no use
    const bool awaited = found != jobs_.end() && found->second.phase == Phase::preparing && found->second.info == info;
    if (!awaited) return settle_and_take(now_s);
    Job& job = found->second;
    if (!prepared) {
        fail_job(job, ReturnReason::tracer_failed);
    } else if (const auto* plan = std::get_if<PlanRead>(&*prepared)) {
        for (const PartFile& part : plan->parts) job.files.emplace(part.file, part.bytes);
        job.files.emplace(plan->whole.file, plan->whole.bytes);
        need(job, plan->whole.file);
    } else {
        ReadyJob& ready = std::get<ReadyJob>(*prepared);
        JobRecord record;
        record.spec = info.spec;
        record.scene_bytes = info.scene_bytes;
        record.status.job = info.job;
        record.status.name = info.spec.name.substr(0, limits::peer_name_bytes_max);
        record.status.priority = info.spec.priority;
        record.status.scene = info.scene;
        record.status.particles = info.spec.particles;
        job.open.emplace(info.job, info.spec, ready.recovered.prepared);
        job.phase = Phase::running;
        route(farm_.begin_lent(std::move(record), std::move(ready.recovered), now_s));
        for (wire::Lease& lease : std::exchange(job.waiting, {})) lend(job, std::move(lease));
        route(farm_.settle(now_s));
    }
    return settle_and_take(now_s);
}

void RelayCore::drop_job(JobId id, double now_s) {
    const auto job = jobs_.find(id);
    if (job == jobs_.end()) return;
    const std::string name = "job " + std::to_string(id);
    count(Discard::set_of_gone_job, job->second.sets.all().size() + job->second.waiting.size(), name);
    const bool has_open = job->second.open && !job->second.open->empty();
    count(Discard::result_of_gone_job, results_.drop(id) + has_open, name);
    answer_pending(id, now_s);
    if (job->second.phase == Phase::running) route(farm_.end_lent(id, now_s));
    const Job gone = std::move(job->second);
    jobs_.erase(job);
    for (const auto& [file, bytes] : gone.files)
        if (!bytes_of(file) && kept_.erase(file) > 0) effects_.push_back(RemoveFile{file});
}

/// The master does not say of these that they are gone when they ended while it was not there.
void RelayCore::drop_jobs_not_held(double now_s) {
    std::vector<JobId> idle;
    for (const auto& [id, job] : jobs_) {
        const bool held =
            !job.sets.empty() || !job.waiting.empty() || results_.has(id) || (job.open && !job.open->empty());
        if (!held) idle.push_back(id);
    }
    for (const JobId id : idle) drop_job(id, now_s);
}

/// A job that this relay can't do: its sets go to others.
void RelayCore::fail_job(Job& job, ReturnReason reason) {
    count(Discard::set_not_traceable, job.sets.all().size() + job.waiting.size(),
          "job " + std::to_string(job.info.job));
    give_all_back(job, reason);
    if (job.phase != Phase::running) job.phase = Phase::failed;
}

void RelayCore::give_back(Job& job, const LentSet& set, ReturnReason reason) {
    farm_.withdraw(job.info.job, set.range);
    job.sets.remove(set.lease);
    returns_.add(reason, set.lease, set.epoch);
}

void RelayCore::give_all_back(Job& job, ReturnReason reason) {
    for (const wire::Lease& lease : std::exchange(job.waiting, {})) returns_.add(reason, lease.lease, lease.epoch);
    for (const LentSet& set : job.sets.all()) give_back(job, set, reason);
}

/// Sets that one worker after the other was lost with, and jobs that no worker can do.
void RelayCore::give_back_what_is_hopeless(Job& job) {
    if (job.phase != Phase::running) return;
    const JobId id = job.info.job;
    for (const ParticleRange& range : farm_.set_aside(id))
        for (const LentSet& set : job.sets.across(range)) give_back(job, set, ReturnReason::lost);
    if (!job.sets.empty() && farm_.nobody_can_trace(id)) fail_job(job, ReturnReason::no_scene);
}

/// Nobody is there who could trace them, and nobody comes back.
void RelayCore::give_back_what_nobody_traces(double now_s) {
    if (farm_.worker_threads() > 0) {
        deserted_s_.reset();
        return;
    }
    if (!deserted_s_) deserted_s_ = now_s;
    if (now_s < *deserted_s_ + reconnect_seconds_) return;
    for (auto& [id, job] : jobs_) give_all_back(job, ReturnReason::ending);
}

bool RelayCore::waits_for_room(JobId id) const {
    return std::any_of(pending_.begin(), pending_.end(), [&](const StoreResult& result) { return result.job == id; });
}

void RelayCore::drain_job(Job& job, double now_s, double drain_by_s) {
    if (job.drain_by_s) return;
    job.drain_by_s = drain_by_s;
    if (job.phase == Phase::running) route(farm_.drain_lent(job.info.job, now_s));
}

/// When the workers have handed over what they had, or time is up.
void RelayCore::end_drain_if_done(JobId id, Job& job, double now_s) {
    if (!job.drain_by_s) return;
    const bool busy = job.phase == Phase::running && (waits_for_room(id) || farm_.ledger(id)->outstanding() > 0);
    if (busy && now_s < *job.drain_by_s) return;
    close(job);
    give_all_back(job, ReturnReason::ending);
}

/// Leases of which the workers have not got all, about.
std::uint64_t RelayCore::sets_ahead(JobId id, const Job& job) const {
    if (job.drain_by_s) return 0;
    if (job.phase != Phase::running) return job.waiting.size();
    const std::uint64_t free = farm_.ledger(id)->unleased();
    if (job.sets.empty() || free == 0) return 0;
    const std::uint64_t mean = job.sets.mean_count();
    return (free + mean - 1) / mean;
}

}  // namespace lumenfarm::relay
