#include "common/support/counted.h"
#include "master/master_core.h"

#include <algorithm>

/// The master's core: how it stands, in one line.
namespace lumenfarm {

std::string MasterCore::summary(double now_s) const {
    std::string running;
    std::size_t waiting = 0;
    for (const auto& [id, job] : jobs_) {
        if (job.phase == Phase::queued && !job.record.paused) ++waiting;
        if (job.phase == Phase::queued || job.phase == Phase::over || job.phase == Phase::removing) continue;
        const wire::JobStatus status = status_of(job, now_s);
        const std::uint64_t percent = status.committed * 100 / std::max<std::uint64_t>(status.particles, 1);
        running += (running.empty() ? "job " : ", job ") + std::to_string(id) + " at " + std::to_string(percent) + " %";
    }
    std::size_t workers = 0, threads = 0;
    for (const auto& [id, session] : sessions_) {
        if (!session.worker()) continue;
        ++workers;
        threads += session.hello.threads;
    }
    std::string line = running.empty() ? "no job runs" : running;
    if (waiting > 0) line += "; " + counted(waiting, "job") + (waiting == 1 ? " waits" : " wait");
    line += "; " + counted(workers, "worker");
    if (workers > 0) line += " with " + counted(threads, "thread");
    if (no_space_) line += "; the disk is full: " + *no_space_;
    return stopping_ ? "ending: " + line : line;
}

}  // namespace lumenfarm
