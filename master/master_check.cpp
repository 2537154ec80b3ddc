#include "master/master_core.h"

#include <algorithm>

/// The master's core, looked through: its books and its bounds.
namespace lumenfarm {

std::optional<std::string> MasterCore::contradiction() const {
    std::size_t staged = 0, active = 0;
    for (const auto& [id, session] : sessions_) {
        const Worker* worker = session.worker();
        if (!worker) continue;
        if (worker->open) staged += worker->open->bytes();
        if (worker->wanted > limits::leases_per_worker_max) return "a worker wants more leases than it may have";
    }
    std::map<JobId, std::size_t> on_their_way;
    for (const auto& [ticket, storing] : storing_) {
        staged += storing.result->bytes();
        ++on_their_way[storing.job];
        if (storing.repeated.size() > limits::repeated_results_max) return "too many results wait for another one";
    }
    if (staged != staged_bytes_)
        return std::to_string(staged) + " bytes of results are staged, not " + std::to_string(staged_bytes_);
    if (staged > limits::staged_bytes_max) return "more bytes of results are staged than may be";
    for (const auto& [id, job] : jobs_) {
        const std::string name = "job " + std::to_string(id) + ": ";
        active += job.active != nullptr;
        if (job.results_on_their_way != on_their_way[id]) return name + "results on their way to the disk are lost";
        if (job.askers.size() > limits::admissions_max) return name + "too many wait for an answer";
        if (!job.active) continue;
        if (const auto fault = job.active->ledger().contradiction()) return name + *fault;
    }
    if (active > limits::active_jobs_max) return "more jobs are active than may be";
    if (sessions_.size() > limits::sessions_max) return "more sessions are open than may be";
    if (admissions_.size() > limits::admissions_max) return "more submissions wait than may";
    if (jobs_.size() > limits::jobs_max) return "more jobs are kept than may be";
    return std::nullopt;
}

}  // namespace lumenfarm
