#include "master/master_core.h"

#include <algorithm>
#include <utility>

/// The master's core: its orderly end.
namespace lumenfarm {

Effects MasterCore::stop(double now_s, double wait_s) {
    stop_by_s_ = stopping_ ? std::min(stop_by_s_, now_s + wait_s) : now_s + wait_s;
    stopping_ = true;
    return settle_and_take(now_s);
}

/// True while somebody waits for what is on its way to the disk. What waits for space there is not on its way.
bool MasterCore::owes_answers() const {
    const bool asked = std::any_of(jobs_.begin(), jobs_.end(), [](const auto& entry) {
        return !entry.second.askers.empty() && entry.second.records_on_their_way > 0;
    });
    return asked || !admissions_.empty() || std::any_of(storing_.begin(), storing_.end(), [](const auto& entry) {
               return !entry.second.waiting_for_space;
           });
}

void MasterCore::stop_when_answered(double now_s) {
    if (!stopped_ && owes_answers() && now_s < stop_by_s_) return;
    for (const auto& [id, job] : jobs_)
        if (job.active && !job.lent && !stopped_) effects_.push_back(StoreSnapshot{id, effort_of(job, now_s), true});
    stopped_ = true;
    while (!sessions_.empty()) {
        const SessionId session = sessions_.begin()->first;
        send(session, wire::Goodbye(wire::GoodbyeReason::shutting_down, "the master ends"));
        effects_.push_back(Close{session});
        forget(session, now_s);
    }
}

}  // namespace lumenfarm
