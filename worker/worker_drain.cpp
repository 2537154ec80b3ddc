#include "common/support/counted.h"
#include "worker/worker_core.h"

#include <map>

/// The worker's core: its orderly end.
namespace lumenfarm::worker {

Effects WorkerCore::drain(double now_s) {
    begin_drain(now_s);
    return settle_and_take(now_s);
}

Effects WorkerCore::end_now(double now_s) {
    begin_drain(now_s);
    drain_by_s_ = now_s;
    return settle_and_take(now_s);
}

void WorkerCore::begin_drain(double now_s) {
    if (drain_by_s_) return;
    drain_by_s_ = now_s + drain_seconds_;
    return_queued(0);
    for (std::size_t i = 0; i < slots_.size(); ++i) stop_slot(i, SlotAsk::close);
}

void WorkerCore::finish_if_drained(double now_s) {
    if (!drain_by_s_ || finished_) return;
    const bool nothing_left = idle() && queue_.empty() && results_.empty() && returns_.empty();
    if (!nothing_left && welcome_ && now_s < *drain_by_s_) return;
    finished_ = true;
    count(Discard::result_undelivered, results_.size(), "the worker ends");
    effects_.push_back(Finished{});
}

std::string WorkerCore::summary() const {
    std::string jobs;
    std::size_t tracing = 0;
    std::map<JobId, std::size_t> slots_by_job;
    for (const Slot& slot : slots_)
        if (slot.running) ++slots_by_job[slot.job];
    for (const auto& [job, slots] : slots_by_job) {
        jobs += (jobs.empty() ? "job " : ", job ") + std::to_string(job);
        tracing += slots;
    }
    std::string line = drain_by_s_ ? "" : fetch_ ? "fetches a scene" : "waits for work";
    if (tracing > 0)
        line =
            "traces " + jobs + " on " + std::to_string(tracing) + " of " + std::to_string(slots_.size()) + " threads";
    const std::uint64_t given_up = counts_.discards.of(Discard::part_given_up);
    if (given_up > 0)
        line += (line.empty() ? "" : "; ") + counted(parts_brought_, "subspace") + " brought in and " +
                std::to_string(given_up) + " given up so far";
    if (!results_.empty())
        line += (line.empty() ? "" : "; ") + counted(results_.size(), "result") + " not acknowledged yet";
    return drain_by_s_ ? "ending" + (line.empty() ? "" : ": " + line) : line;
}

}  // namespace lumenfarm::worker
