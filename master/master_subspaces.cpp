#include "master/master_core.h"

#include <algorithm>

/// The master's core: which subspace's particles a worker gets (docs/subspaces.md).
namespace lumenfarm {

/// A cancelled job emits no more, and follows what is in flight to its end.
bool MasterCore::drains(const Job& job) { return job.record.cancel_asked && job.active->prepared().subspaces; }

void MasterCore::begin_draining(Job& job, double now_s) {
    job.active->ledger().end_emission();
    job.end_by_s = now_s + limits::finish_seconds;
}

/// Nothing is in flight any more, nor with a worker.
bool MasterCore::has_drained(const Job& job) {
    return job.active->ledger().outstanding() == 0 && job.active->ledger().in_flight() == 0;
}

/// While workers hold parts of the scene, and much of the job is to come. Twice as many hits as at the last cut know
/// more.
void MasterCore::look_at_cut(Job& job, double now_s) {
    const bool may = policy_.recut_above && job.phase == Phase::running && job.active->prepared().subspaces &&
                     !job.lent && !job.record.cancel_asked && !no_space_;
    if (!may || now_s < job.measured_s + policy_.recut_seconds) return;
    job.measured_s = now_s;
    const Ledger& ledger = job.active->ledger();
    const std::uint64_t hits = job.active->balance().hits;
    if (2 * ledger.committed_particles() > ledger.particles() || hits < policy_.recut_hits ||
        hits < 2 * job.cut_at_hits)
        return;
    const bool in_parts = std::any_of(sessions_.begin(), sessions_.end(), [&](const auto& entry) {
        const Worker* worker = entry.second.worker();
        const auto parts = worker ? worker->parts.find(job.record.id()) : std::map<JobId, Parts>::const_iterator();
        return worker && parts != worker->parts.end() && !parts->second.all;
    });
    if (in_parts) effects_.push_back(MeasureCut{job.record.id(), *policy_.recut_above});
}

/// The job is put aside, and cut when it goes on.
Effects MasterCore::on_cut_measured(const MeasureCut& measure, const Evenness& evenness, double now_s) {
    Job* job = find(measure.job);
    const bool runs = job && job->phase == Phase::running && !job->record.cancel_asked;
    if (runs && policy_.recut_above && evenness.is_worth_a_cut(*policy_.recut_above)) {
        job->cut_at_hits = job->active->balance().hits;
        job->resumes = true;
        wind_up(*job, now_s);
    }
    return settle_and_take(now_s);
}

/// The fullest of the subspaces that the worker has, while it is worth a set. Else the fullest that it has memory for.
/// Else a light, unless too much is in flight. Else the fullest of all: the worker gives up what it has for it.
std::optional<std::uint32_t> MasterCore::next_source(const Job& job, const Worker& worker) const {
    const Ledger& ledger = job.active->ledger();
    const auto lights = static_cast<std::uint32_t>(ledger.lights());
    const auto known = worker.parts.find(job.record.id());
    const Parts parts = known == worker.parts.end() ? Parts{} : known->second;
    const auto& queues = ledger.queues();
    const auto fullest = [&](auto wanted) -> std::optional<std::uint32_t> {
        const auto found = std::find_if(queues.rbegin(), queues.rend(), wanted);
        return found == queues.rend() ? std::nullopt : std::optional(found->second);
    };
    const auto is_here = [&](const auto& queue) { return parts.held.contains(queue.second - lights); };
    const auto here = fullest(is_here);
    if (here && ledger.waiting(*here) >= limits::first_set_particles) return here;
    const auto& files = job.active->files().parts;
    const auto fits = [&](const auto& queue) {
        return !is_here(queue) && files[queue.second - lights].triangles <= parts.room_triangles;
    };
    if (const auto next = known == worker.parts.end() ? std::nullopt : fullest(fits)) return next;
    if (ledger.queued() < limits::flights_waiting_max)
        if (const auto light = ledger.next_light()) return light;
    return here ? here : fullest([](const auto&) { return true; });
}

/// So that the sets of all its threads fit its outbox, and what they give back the bounds of the master. A worker that
/// has every subspace gives nothing back, but of what has left very many hits (limits::hits_per_slice_max).
std::uint64_t MasterCore::particles_per_set_max(const Job& job, const Session& session, std::uint32_t source) {
    const auto parts = session.worker()->parts.find(job.record.id());
    const bool has_all = parts != session.worker()->parts.end() && parts->second.all;
    if (has_all && source < job.active->ledger().lights()) return limits::flights_waiting_max;
    const std::uint64_t sets = session.is_relay() ? limits::leases_of_relay : 2 * std::uint64_t{session.hello.threads};
    return std::clamp<std::uint64_t>(limits::flights_per_worker_max / sets, 1, limits::flights_per_message_max);
}

}  // namespace lumenfarm
