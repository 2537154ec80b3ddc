#include "relay/relay_core.h"

#include <algorithm>
#include <array>
#include <utility>

/// The relay's core: results of its workers are taken, added up and handed up.
namespace lumenfarm::relay {

/// Workers wait for their answers while more is on its way up than may be.
void RelayCore::merge_pending(double now_s) {
    while (!pending_.empty() && results_.bytes() < bytes_in_flight_) {
        const StoreResult next = std::move(pending_.front());
        pending_.pop_front();
        Job& job = jobs_.at(next.job);
        const auto& covered = next.result->done().claims;
        if (const auto claims = job.sets.claims_of(covered)) {
            merge(job, *next.result, *claims, now_s);
        } else {
            // some of it went back while it waited, so all that it covers does
            for (const wire::Claim& part : covered)
                for (const LentSet& set : job.sets.across(part.range)) give_back(job, set, wire::ReturnReason::ending);
        }
        route(farm_.on_results_stored(std::array{next.ticket}, std::map<JobId, Merged>(), now_s));
    }
}

/// They are of no use any more.
void RelayCore::answer_pending(JobId id, double now_s) {
    std::vector<std::uint64_t> tickets;
    std::erase_if(pending_, [&](const StoreResult& result) {
        if (result.job != id) return false;
        tickets.push_back(result.ticket);
        return true;
    });
    if (!tickets.empty()) route(farm_.on_results_stored(tickets, std::map<JobId, Merged>(), now_s));
}

void RelayCore::merge(Job& job, const StagedResult& result, const std::vector<wire::Claim>& claims, double now_s) {
    if (!job.open->empty() && !job.open->has_room_for(result)) close(job);
    if (job.open->empty()) job.open_since_s = now_s;
    job.open->add(result, claims);
    job.sets.claim(claims);
    if (job.open->full()) close(job);
}

void RelayCore::close(Job& job) {
    if (!job.open || job.open->empty()) return;
    results_.add(job.open->take());
    job.flush_s = std::min(2 * job.flush_s, job.info.flush_seconds);
}

/// Hits go up as they come, as far as the master's credit goes. Sums wait for more to be added: not for long once the
/// workers have all that is here, since those may be the last of the job; and not at all when nothing is left to wait
/// for.
void RelayCore::close_what_is_due(double now_s) {
    for (auto& [id, job] : jobs_) {
        if (!job.open || job.open->empty()) continue;
        const Ledger& ledger = *farm_.ledger(id);
        const bool may_be_last = welcome_ && ledger.unleased() == 0 && ledger.lost().waiting_particles() == 0;
        const double wait_s = may_be_last ? std::min(job.flush_s, limits::first_flush_seconds) : job.flush_s;
        const bool late = now_s - job.open_since_s >= wait_s;
        const bool may_go = job.info.spec.packing == Packing::records && results_.size() < credit_;
        if (late || job.sets.empty() || may_go) close(job);
    }
}

bool RelayCore::claimed(std::uint64_t lease) const {
    return results_.claims(lease) || std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& entry) {
               return entry.second.open && entry.second.open->claims(lease);
           });
}

void RelayCore::take_ack(const wire::ResultAck& ack) {
    const auto parcel = results_.take(ack.result);
    if (!parcel) return ignore(ack);
    counts_.verdicts.count(ack.verdict);
    if (ack.verdict == wire::Verdict::accepted) {
        particles_merged_ += parcel->balance.particles;
        return;
    }
    count(worker::Discard::result_refused, 1, std::string(wire::name_of(ack.verdict)) + ": " + ack.sentence);
    if (const auto job = jobs_.find(parcel->job); job != jobs_.end()) leave(job->second, parcel->claims);
}

/// The master above has taken the leases of a refused result back: what goes on with one of them would be refused, too.
/// All are returned: a new life of the master may have forgotten that it took them back.
void RelayCore::leave(Job& job, const std::vector<wire::Claim>& claims) {
    std::map<std::uint64_t, std::uint32_t> left;  // lease and epoch
    for (const wire::Claim& claim : claims) left.emplace(claim.lease, claim.epoch);
    const auto is_left = [&](const wire::Claim& claim) { return left.contains(claim.lease); };
    if (job.open && std::any_of(job.open->claims().begin(), job.open->claims().end(), is_left)) {
        for (const wire::Claim& claim : job.open->claims()) left.emplace(claim.lease, claim.epoch);
        job.open->clear();
    }
    for (const auto& [lease, epoch] : left) {
        if (const auto set = job.sets.remove(lease)) farm_.withdraw(job.info.job, set->range);
        returns_.add(wire::ReturnReason::ending, lease, epoch);
    }
}

}  // namespace lumenfarm::relay
