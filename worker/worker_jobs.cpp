#include "worker/worker_core.h"

#include <algorithm>
#include <set>
#include <utility>

/// The worker's core: jobs, and the scenes that they need.
namespace lumenfarm::worker {

namespace {

/// A number may stand for another job when the master has lost its storage.
bool is_same_job(const wire::JobInfo& a, const wire::JobInfo& b) {
    return a.scene == b.scene && same_but_for_particles(a.spec, b.spec);
}

}  // namespace

bool WorkerCore::ready(JobId id) const {
    const auto job = jobs_.find(id);
    return job != jobs_.end() && job->second.context && !draining(id);
}

bool WorkerCore::draining(JobId id) const {
    const auto job = jobs_.find(id);
    return drain_by_s_.has_value() || (job != jobs_.end() && job->second.draining);
}

void WorkerCore::take_job(const wire::JobInfo& info) {
    const auto known = jobs_.find(info.job);
    if (known != jobs_.end()) {
        if (is_same_job(known->second.info, info) && !known->second.failed) {
            known->second.info = info;
            known->second.confirmed = true;
            known->second.draining = false;
            return tell_parts(info.job);
        }
        // the job is another one now: what this worker has of it is nobody's
        for (const wire::LeaseProgress& lease : leases_held())
            if (lease.job == info.job)
                returns_.add(wire::ReturnReason::ending, lease.lease, static_cast<std::uint32_t>(lease.lease >> 32));
        drop_job(info.job);
    }
    Job job;
    job.info = info;
    job.confirmed = job.loading = true;
    const auto loads = [&](const auto& entry) { return entry.second.loading && entry.second.info.scene == info.scene; };
    if (std::none_of(jobs_.begin(), jobs_.end(), loads)) effects_.push_back(LoadScene{info.scene});
    jobs_.emplace(info.job, std::move(job));
}

void WorkerCore::take_lease(const wire::Lease& lease) {
    ++leases_received_;
    if (wished_ > 0) --wished_;
    const auto job = jobs_.find(lease.job);
    const bool failed = job != jobs_.end() && job->second.failed;
    if (!failed && !is_possible(lease)) {
        count(Discard::set_not_traceable, 1, "a set of job " + std::to_string(lease.job) + " is impossible");
        returns_.add(wire::ReturnReason::tracer_failed, lease.lease, lease.epoch);
        return;
    }
    if (!failed && !draining(lease.job)) return queue_.push_back(lease);
    returns_.add(failed ? wire::ReturnReason::no_scene : wire::ReturnReason::ending, lease.lease, lease.epoch);
}

void WorkerCore::drop_job(JobId id) {
    if (jobs_.erase(id) == 0) return;
    close_parts(id);
    const std::string job = "job " + std::to_string(id);
    std::size_t sets = std::erase_if(queue_, [&](const wire::Lease& lease) { return lease.job == id; });
    std::size_t results = results_.drop(id);
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        if (slots_[i].job != id) continue;
        sets += slots_[i].lease.has_value();
        results += slots_[i].open;
        stop_slot(i, SlotAsk::abandon);
    }
    count(Discard::set_of_gone_job, sets, job);
    count(Discard::result_of_gone_job, results, job);
}

/// The master does not say of these that they are gone when they ended while it was not here.
void WorkerCore::drop_jobs_not_held() {
    std::set<JobId> held;
    for (const wire::Lease& lease : queue_) held.insert(lease.job);
    for (const auto& [lease, job] : results_.leases()) held.insert(job);
    for (const Slot& slot : slots_)
        if (slot.running || slot.open || slot.lease) held.insert(slot.job);
    for (auto job = jobs_.begin(); job != jobs_.end();) {
        const JobId id = (job++)->first;
        if (!held.contains(id)) drop_job(id);
    }
}

/// What is done goes to the master, the rest goes back.
void WorkerCore::drain_job(JobId id) {
    const auto job = jobs_.find(id);
    if (job == jobs_.end()) return;
    job->second.draining = true;
    return_queued(id);
    for (std::size_t i = 0; i < slots_.size(); ++i)
        if (slots_[i].job == id) stop_slot(i, SlotAsk::close);
}

/// A job that this worker can't do: its sets go to others.
void WorkerCore::fail_job(JobId id, wire::ReturnReason reason) {
    jobs_.at(id).failed = true;
    close_parts(id);
    const std::size_t returned = std::erase_if(queue_, [&](const wire::Lease& lease) {
        if (lease.job != id) return false;
        returns_.add(reason, lease.lease, lease.epoch);
        return true;
    });
    count(Discard::set_not_traceable, returned, "job " + std::to_string(id));
}

Effects WorkerCore::on_scene_loaded(const Digest& scene, std::shared_ptr<const std::vector<std::byte>> bytes,
                                    double now_s) {
    if (bytes) {
        prepare_jobs_of(scene, bytes);
        prepare_part_of(scene, bytes);
    } else {
        if (bringing_ && bringing_->file.file == scene) bringing_->missing = true;
        for (auto& [id, job] : jobs_)
            if (job.info.scene == scene && std::exchange(job.loading, false)) job.missing = true;
        fetch_next();
    }
    return settle_and_take(now_s);
}

void WorkerCore::fetch_next() {
    if (fetch_) return;
    const auto waits = [](const auto& entry) { return entry.second.missing && !entry.second.failed; };
    const auto next = std::find_if(jobs_.begin(), jobs_.end(), waits);
    if (next != jobs_.end()) {
        fetch_.emplace(next->second.info.scene, next->second.info.scene_bytes);
    } else if (bringing_ && bringing_->missing) {
        fetch_.emplace(bringing_->file.file, bringing_->file.bytes);
    } else {
        return;
    }
    if (!welcome_) return;
    for (wire::Message& request : fetch_->begin_session()) send(std::move(request));
}

void WorkerCore::take_requests(const Result<std::vector<wire::Message>>& requests) {
    if (fetch_->dropped()) count(*fetch_->dropped(), 1, "of scene " + fetch_->scene().hex());
    if (!requests) return fail_fetch(requests.error().sentence);
    for (const wire::Message& request : *requests) send(request);
    const auto bytes = fetch_->complete();
    if (!bytes) return;
    const Digest scene = fetch_->scene();
    fetch_.reset();
    prepare_jobs_of(scene, bytes);
    prepare_part_of(scene, bytes);
    // a disk may take its time
    effects_.push_back(KeepScene{scene, bytes});
    fetch_next();
}

void WorkerCore::fail_fetch(const std::string& why) {
    const Digest scene = fetch_->scene();
    count(Discard::scene_not_fetched, 1, scene.hex() + ": " + why);
    fetch_.reset();
    for (auto& [id, job] : jobs_)
        if (job.info.scene == scene && job.missing) fail_job(id, wire::ReturnReason::no_scene);
    if (bringing_ && bringing_->file.file == scene) fail_bringing(wire::ReturnReason::no_scene);
    fetch_next();
}

void WorkerCore::prepare_jobs_of(const Digest& scene, const std::shared_ptr<const std::vector<std::byte>>& bytes) {
    for (auto& [id, job] : jobs_) {
        if (job.info.scene != scene) continue;
        job.loading = job.missing = false;
        if (job.context || job.failed || std::exchange(job.preparing, true)) continue;
        effects_.push_back(PrepareJob{job.info, bytes});
    }
}

void WorkerCore::take_context(Job& job, std::shared_ptr<const JobContext> context) {
    job.context = std::move(context);
    if (const auto opened = open_parts(job); !opened) {
        count(Discard::memory_too_small, 1, "job " + std::to_string(job.info.job) + ": " + opened.error().sentence);
        return fail_job(job.info.job, wire::ReturnReason::no_scene);
    }
    const std::size_t impossible = std::erase_if(queue_, [&](const wire::Lease& lease) {
        if (lease.job != job.info.job || is_possible(lease)) return false;
        returns_.add(wire::ReturnReason::tracer_failed, lease.lease, lease.epoch);
        return true;
    });
    count(Discard::set_not_traceable, impossible, "sets of job " + std::to_string(job.info.job) + " are impossible");
    tell_parts(job.info.job);
}

Effects WorkerCore::on_job_prepared(const wire::JobInfo& info, Result<std::shared_ptr<const JobContext>> prepared,
                                    double now_s) {
    const auto found = jobs_.find(info.job);
    // what was prepared for an earlier JobInfo of that number is of no use, unless it said the same
    if (found != jobs_.end() && is_same_job(info, found->second.info) && !found->second.context) {
        found->second.preparing = false;
        if (prepared) {
            take_context(found->second, std::move(*prepared));
        } else {
            fail_job(info.job, wire::ReturnReason::tracer_failed);
        }
    }
    return settle_and_take(now_s);
}

}  // namespace lumenfarm::worker
