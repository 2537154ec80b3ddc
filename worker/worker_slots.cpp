#include "worker/worker_core.h"

#include <algorithm>
#include <utility>

/// The worker's core: feeding the tracing slots and taking what they report.
namespace lumenfarm::worker {

Effects WorkerCore::on_slot(std::size_t index, SlotReport report, double now_s) {
    Slot& slot = slots_[index];
    slot.running = slot.close_asked = false;
    if (slot.abandoned) {
        slot.abandoned = report.set_left || report.open;
        if (!slot.abandoned) slot = {};
    } else {
        take_report(slot, report);
    }
    return settle_and_take(now_s);
}

void WorkerCore::take_report(Slot& slot, SlotReport& report) {
    const auto job = jobs_.find(slot.job);
    if (report.result && job == jobs_.end()) {
        count(Discard::result_of_gone_job, 1, "job " + std::to_string(slot.job));
    } else if (report.result) {
        job->second.has_results = true;
        results_.add(std::move(*report.result));
    }
    slot.open = report.open;
    if (!report.open) slot.open_leases.clear();
    if (!report.set_left) slot.lease.reset();
}

/// Says what a slot that waits does next.
void WorkerCore::feed(std::size_t index, double now_s) {
    Slot& slot = slots_[index];
    if (slot.running) return;
    if (slot.abandoned) return stop_slot(index, SlotAsk::abandon);
    if (draining(slot.job) && slot.open) return stop_slot(index, SlotAsk::close);
    if (draining(slot.job) && slot.lease) {
        returns_.add(wire::ReturnReason::ending, slot.lease->lease, slot.lease->epoch);
        return stop_slot(index, SlotAsk::abandon);
    }
    if (!room_for_results()) return;
    if (!slot.lease) return start_next(index, now_s);
    if (!slot.open) slot.open_since_s = now_s;
    slot.open_leases.emplace(slot.lease->lease, slot.lease->epoch);
    slot.open = slot.running = true;
    effects_.push_back(ContinueSlot{index});
}

void WorkerCore::start_next(std::size_t index, double now_s) {
    Slot& slot = slots_[index];
    const auto first_of = [&](auto fits) { return std::find_if(queue_.begin(), queue_.end(), fits); };
    const auto goes_along = [&](const wire::Lease& lease) {
        return lease.job == slot.job && lease.audit == slot.audit && !lease.apart && !slot.apart;
    };
    auto next = slot.open ? first_of([&](const wire::Lease& lease) { return goes_along(lease) && is_at_hand(lease); })
                          : queue_.end();
    if (next == queue_.end() || !ready(*next)) next = first_of([&](const wire::Lease& lease) { return ready(lease); });
    if (slot.open) {
        const auto job = jobs_.find(slot.job);
        const bool late = job == jobs_.end() || now_s - slot.open_since_s >= job->second.flush_s();
        if (late || next == queue_.end() || !goes_along(*next)) return stop_slot(index, SlotAsk::close);
    }
    if (next == queue_.end()) return;
    if (!slot.open) slot.open_since_s = now_s;
    slot.lease = *next;
    slot.job = next->job;
    slot.audit = next->audit;
    slot.apart = next->apart;
    slot.open_leases.emplace(next->lease, next->epoch);
    slot.open = slot.running = true;
    SetWork work{jobs_.at(next->job).context, next->lease, next->epoch, next->range, next->keep_threshold};
    if (const auto piece = piece_for(*next)) shelf_.use(*piece);
    if (has_subspaces(next->job)) work.territory = shelf_.territory(next->job);
    work.flights = std::move(next->flights);
    effects_.push_back(StartSlot{index, std::move(work)});
    queue_.erase(next);
}

void WorkerCore::stop_slot(std::size_t index, SlotAsk ask) {
    Slot& slot = slots_[index];
    if (ask == SlotAsk::abandon) slot.abandoned = true;
    if (slot.running) {
        effects_.push_back(InterruptSlot{index, ask});
    } else if (slot.open || slot.lease) {
        slot.running = true;
        effects_.push_back(TellSlot{index, ask});
    } else {
        slot.abandoned = false;
    }
}

/// A result is closed in the middle of a long set, so that no particle waits for long.
void WorkerCore::interrupt_late(double now_s) {
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        Slot& slot = slots_[i];
        const auto job = jobs_.find(slot.job);
        if (!slot.running || !slot.open || slot.abandoned || slot.close_asked || job == jobs_.end()) continue;
        if (now_s - slot.open_since_s < job->second.flush_s()) continue;
        slot.close_asked = true;
        effects_.push_back(InterruptSlot{i, SlotAsk::close});
    }
}

/// Gives back the sets that wait for a slot: of one job, or of all (0).
void WorkerCore::return_queued(JobId only) {
    std::erase_if(queue_, [&](const wire::Lease& lease) {
        if (only != 0 && lease.job != only) return false;
        returns_.add(wire::ReturnReason::ending, lease.lease, lease.epoch);
        return true;
    });
}

/// The master has taken every lease of a refused result back. Slots that go on with one of them would only make
/// results that are refused, too, and take further leases along. All are returned: a new life of the master may have
/// forgotten that it took them back.
void WorkerCore::leave_refused(const Parcel& refused) {
    std::map<std::uint64_t, std::uint32_t> left;  // lease and epoch
    for (const wire::Claim& claim : refused.claims) left.emplace(claim.lease, claim.epoch);
    const std::map<std::uint64_t, std::uint32_t> named = left;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        const Slot& slot = slots_[i];
        const auto concerns = [&](const auto& open) { return named.contains(open.first); };
        if (slot.abandoned || slot.job != refused.job) continue;
        if (std::none_of(slot.open_leases.begin(), slot.open_leases.end(), concerns) &&
            !(slot.lease && named.contains(slot.lease->lease)))
            continue;
        if (slot.lease) left.emplace(slot.lease->lease, slot.lease->epoch);
        left.insert(slot.open_leases.begin(), slot.open_leases.end());
        stop_slot(i, SlotAsk::abandon);
    }
    for (const auto& [lease, epoch] : left) returns_.add(wire::ReturnReason::ending, lease, epoch);
}

bool WorkerCore::idle() const {
    return std::none_of(slots_.begin(), slots_.end(),
                        [](const Slot& slot) { return slot.running || slot.open || slot.lease; });
}

}  // namespace lumenfarm::worker
