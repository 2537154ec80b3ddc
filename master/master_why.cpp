#include "common/support/counted.h"
#include "master/master_core.h"

#include <algorithm>
#include <cmath>

/// The master's core: what a job waits for, in one sentence for people.
namespace lumenfarm {

namespace {

std::string name_of(JobId job) { return "job " + std::to_string(job); }

/// Empty when nothing was set aside.
std::string set_aside_text(const wire::JobStatus& status) {
    if (status.set_aside.empty()) return {};
    const ParticleRange& range = status.set_aside.front();
    const std::string light = std::to_string(range.source);
    const std::string particles = std::to_string(range.first) + ".." + std::to_string(range.first + range.count - 1);
    const std::size_t more = status.set_aside.size() - 1;
    return counted(limits::losses_max, "worker") + " were lost with particles " + particles + " of light " + light +
           (more > 0 ? " (and as many of " + counted(more, "other range") + ")" : "") + ", which are set aside; `" +
           "lumenfarm trace SCENE --light " + light + " --particles " + particles + "` traces them";
}

}  // namespace

std::string MasterCore::why(const Job& job, double now_s) const {
    const std::string name = name_of(job.record.id());
    if (stopping_) return "the master ends; " + name + " goes on when it starts again";
    if (no_space_ && !job.record.paused) return name + " waits for room on the master's disk: " + *no_space_;
    switch (job.phase) {
        case Phase::queued: return why_queued(job);
        case Phase::preparing: return "the master reads the scene of " + name;
        case Phase::running: return why_running(job, now_s);
        case Phase::put_aside: return "what " + name + " has is being kept on the disk";
        case Phase::storing: return "the solution of " + name + " is being written";
        case Phase::ending: break;
        case Phase::over:
        case Phase::removing: return name + " is over";
    }
    return name + " waits for the results that " + counted(job.active->ledger().workers(), "worker") +
           " still have, at most " + std::to_string(static_cast<int>(std::ceil(std::max(0.0, job.end_by_s - now_s)))) +
           " s longer; it gets no more sets";
}

std::string MasterCore::why_queued(const Job& job) const {
    const std::string name = name_of(job.record.id());
    const std::string resume = "`lumenfarm resume " + std::to_string(job.record.id()) + "`";
    if (const std::string aside = set_aside_text(job.record.status); job.record.paused && !aside.empty())
        return name + " is paused since " + aside + ", " + resume + " tries them again, `cancel` keeps what is done";
    if (is_held_back(job.record))
        return name + " is paused since it can't go on: " + job.record.status.sentence + "; " + resume +
               " tries again (a damaged scene is mended by another job of it), `cancel` gives up what is done";
    if (job.record.paused) return name + " is paused; " + resume + " lets it go on";
    for (const auto& [id, other] : jobs_)
        if (other.phase == Phase::running && other.record.spec.priority > job.record.spec.priority &&
            other.active->ledger().unleased() > 0)
            return name + " waits for " + name_of(id) + ", which has a higher priority (" +
                   std::to_string(other.record.spec.priority) + ", not " + std::to_string(job.record.spec.priority) +
                   ") and " + std::to_string(other.active->ledger().unleased()) + " particles left to give out";
    const auto active = static_cast<std::uint64_t>(
        std::count_if(jobs_.begin(), jobs_.end(), [](const auto& entry) { return entry.second.active != nullptr; }));
    if (active >= limits::active_jobs_max)
        return name + " waits for one of " + std::to_string(active) + " jobs that share the farm to end";
    return name + " is about to begin";
}

std::string MasterCore::why_running(const Job& job, double now_s) const {
    const std::string name = name_of(job.record.id());
    const Ledger& ledger = job.active->ledger();
    if (has_liars(job))
        return name + " has lost what " + counted(job.record.liars.size(), "worker") +
               " had traced: others contradicted it; that is traced again";
    std::uint64_t connected = 0, unable = 0;
    for (const auto& [id, session] : sessions_) {
        const Worker* worker = session.worker();
        if (!worker) continue;
        ++connected;
        unable += worker->declined.contains(job.record.id());
    }
    if (job.lent && ledger.lent() == 0) return name + " waits for sets of the master at " + policy_.upstream;
    if (connected == 0 && ledger.outstanding() == 0) return name + " waits for a worker: none is connected";
    if (connected == 0)
        return name + " waits for workers to come back: none is connected, and " +
               counted(ledger.outstanding(), "lease") + " are kept for them for a while";
    if (unable == connected)
        return name + " waits for another worker: " + counted(unable, "worker") +
               " that are connected could not load its scene (see their logs)";
    if (drains(job))
        return name + " is being cancelled: it emits no more, and follows " + counted(ledger.in_flight(), "particle") +
               " in flight to their end";
    if (ledger.unleased() > 0 && ledger.outstanding() == 0)
        return name + " waits for its turn among the jobs that share " + counted(connected, "worker");
    if (ledger.complete())
        return name + " waits for " + counted(audits_.pending(job.record.id()), "audit") + " to end" +
               (audits_.disputed(job.record.id()) > 0
                    ? "; two workers contradict each other, and a third has to be there to decide"
                    : "");
    if (!ledger.lost().set_aside().empty())
        return name + " goes on without some particles: " + set_aside_text(counts_of(job, now_s));
    if (ledger.unleased() > 0)
        return name + " is being traced by " + counted(ledger.workers(), "worker") + "; nothing holds it up";
    const std::uint64_t owed = ledger.particles() - ledger.committed_particles();
    if (owed == 0)
        return name + " waits for its last " + counted(ledger.in_flight(), "particle") + " in flight, which are with " +
               counted(ledger.workers(), "worker");
    return name + " waits for its last " + std::to_string(owed) + " particles, which are with " +
           counted(ledger.workers(), "worker");
}

}  // namespace lumenfarm
