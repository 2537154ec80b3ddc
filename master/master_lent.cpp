#include "common/support/ensure.h"
#include "master/master_core.h"

#include <algorithm>
#include <utility>

/// The master's core in a relay: jobs whose particles a master above lends (docs/relays.md).
namespace lumenfarm {

Effects MasterCore::begin_lent(JobRecord record, RecoveredJob recovered, double now_s) {
    ensure(!jobs_.contains(record.id()), "a job is lent once");
    Job& job = jobs_[record.id()];
    job.record = std::move(record);
    job.lent = true;
    job.phase = Phase::running;
    job.active = std::make_unique<ActiveJob>(job.record.spec, std::move(recovered), now_s, now_s);
    job.record.status.state = wire::JobState::running;
    job.record.status.packing = job.active->packing();
    return settle_and_take(now_s);
}

bool MasterCore::lend(JobId id, const ParticleRange& range, FlightQueues::Flights flights,
                      std::uint64_t keep_threshold) {
    Job& job = jobs_.at(id);
    if (!job.active->may_lend(range)) return false;
    job.active->set_keep_threshold(keep_threshold);
    job.active->lend(range, std::move(flights));
    return true;
}

void MasterCore::withdraw(JobId id, const ParticleRange& range) { jobs_.at(id).active->withdraw(range); }

Effects MasterCore::drain_lent(JobId id, double now_s) {
    wind_up(jobs_.at(id), now_s);
    return settle_and_take(now_s);
}

void MasterCore::resume_lent(JobId id) {
    Job& job = jobs_.at(id);
    if (job.phase != Phase::ending) return;
    job.phase = Phase::running;
    // workers that were told to hand it over return its sets until they hear of it again
    for (auto& [session_id, session] : sessions_)
        if (Worker* worker = session.worker(); worker && worker->told.erase(id) > 0) tell(session, *worker, job);
}

Effects MasterCore::end_lent(JobId id, double now_s) {
    Job& job = jobs_.at(id);
    ensure(job.results_on_their_way == 0, "what was handed up was answered");
    job.active->ledger().release_all();
    tell_gone(job);
    jobs_.erase(id);
    return settle_and_take(now_s);
}

std::vector<ParticleRange> MasterCore::set_aside(JobId id) const {
    std::vector<ParticleRange> ranges;
    for (const LostSet& lost : jobs_.at(id).active->ledger().lost().set_aside()) ranges.push_back(lost.range);
    return ranges;
}

bool MasterCore::nobody_can_trace(JobId id) const { return nobody_can_trace(jobs_.at(id)); }

wire::PartsHeld MasterCore::parts_held(JobId id) const {
    std::set<std::uint32_t> held;
    wire::PartsHeld together(id, {}, 0, true);
    for (const auto& [session_id, session] : sessions_) {
        if (!session.worker()) continue;
        const auto parts = session.worker()->parts.find(id);
        together.all = together.all && parts != session.worker()->parts.end() && parts->second.all;
        if (parts == session.worker()->parts.end()) continue;
        held.insert(parts->second.held.begin(), parts->second.held.end());
        together.room_triangles = std::max(together.room_triangles, parts->second.room_triangles);
    }
    together.all = together.all && !held.empty();
    together.subspaces.assign(held.begin(), held.end());
    return together;
}

std::uint32_t MasterCore::worker_threads() const {
    std::uint64_t threads = 0;
    for (const auto& [id, session] : sessions_)
        if (session.worker()) threads += session.hello.threads;
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(threads, limits::threads_behind_relay_max));
}

}  // namespace lumenfarm
