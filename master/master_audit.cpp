#include "master/master_core.h"

#include "master/result_fingerprint.h"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <utility>

/// The master's core: results that are traced a second time, and what becomes of workers that lied.
namespace lumenfarm {

namespace {

/// Neighbouring parts of sets become one range.
std::vector<ParticleRange> ranges_of(const wire::ResultDone& done) {
    std::map<std::uint32_t, IntervalSet> by_light;
    for (const wire::Claim& claim : done.claims)
        by_light[claim.range.source].insert(claim.range.first, claim.range.first + claim.range.count);
    std::vector<ParticleRange> ranges;
    for (const auto& [light, intervals] : by_light)
        for (const auto& interval : intervals.intervals())
            for (std::uint64_t first = interval.begin; first < interval.end; first += limits::particles_per_set_max)
                ranges.push_back({light, first, std::min(interval.end - first, limits::particles_per_set_max)});
    return ranges;
}

}  // namespace

/// By a chance that no worker can foresee. Not with subspaces: what comes back of a set depends on those that the
/// worker has, so two results of one set differ.
void MasterCore::audit(const Job& job, const Storing& stored, std::uint64_t ticket, double now_s) {
    const double chance =
        std::ldexp(static_cast<double>(XXH3_64bits_withSeed(&ticket, sizeof ticket, policy_.audit_key)), -64);
    if (job.active->prepared().subspaces) return;
    if (job.phase != Phase::running || chance >= policy_.audit_fraction || liars_.contains(stored.machine)) return;
    if (audits_.size() >= limits::audits_max) return count(Discard::audit_hopeless, 1, "too many wait already");
    const std::uint64_t threshold = job.active->keep_threshold();
    const wire::ResultDone& done = stored.result->done();
    const double patience_s = limits::audit_seconds + limits::audit_slowness_max * done.trace_seconds;
    audits_.begin(job.record.id(), stored.machine, ranges_of(done), now_s, patience_s, threshold,
                  result_fingerprint(*stored.result, threshold, policy_.audit_key));
}

/// Not to a relay, which would not give it to one worker alone.
bool MasterCore::give_audit_set(Session& session, Worker& worker, const std::vector<Job*>& jobs, double now_s) {
    if (session.is_relay()) return false;
    for (Job* job : jobs) {
        const JobId id = job->record.id();
        if (has_liars(*job) || worker.declined.contains(id) || !audits_.has_set(id, session.machine())) continue;
        const LeaseId lease = new_lease();
        const Audits::Set set = audits_.give(id, session.machine(), lease, now_s);
        tell(session, worker, *job);
        worker.count_lease(id);
        send(session.id, wire::Lease(lease, policy_.epoch, id, set.range, set.keep_threshold, set.audit));
        return true;
    }
    return false;
}

/// True when the result was of an audit.
bool MasterCore::take_audit(Session& session, StagedResult& result, wire::ResultDone& done, double now_s) {
    const std::vector<Claim> claims = claims_of(done);
    if (claims.empty() || !audits_.holds(claims.front().lease)) return false;
    const auto audit = audits_.check(session.machine(), claims);
    const JobId job = done.job;
    const std::uint64_t number = done.result;
    Outcome outcome;
    if (!audit || audits_.job(*audit) != job) {
        outcome = {wire::Verdict::stale, "it covers particles that this worker was not to trace again"};
    } else if (const auto whole = result.complete(jobs_.at(job).active->prepared(), std::move(done)); !whole) {
        outcome = {result.blameless() ? wire::Verdict::stale : wire::Verdict::invalid, whole.error().sentence};
    }
    if (outcome.verdict != wire::Verdict::accepted) {
        audits_.forget(session.machine(), claims.front().lease, now_s);
        answer(session.instance(), job, number, outcome, now_s);
        return true;
    }
    const std::uint64_t said = result_fingerprint(result, audits_.keep_threshold(*audit), policy_.audit_key);
    answer(session.instance(), job, number, outcome, now_s);
    Job& audited = jobs_.at(job);
    if (const auto finding = audits_.take(*audit, claims, said)) {
        ++audited.record.status.audits;
        for (const MachineId liar : finding->liars)
            condemn(liar, job, Discard::quarantined,
                    "two other machines contradict what this one has traced for job " + std::to_string(job), now_s);
    }
    if (Job* still = find(job); still && still->active) end_if_finished(*still, now_s);
    return true;
}

/// The liar is kept out, and in a farm with audits nothing that it has committed to a job that is not over is believed.
void MasterCore::condemn(MachineId liar, JobId found_in, Discard reason, const std::string& sentence, double now_s) {
    if (!liars_.insert(liar).second) return;
    if (Job* job = find(found_in)) ++job->record.status.liars;
    audits_.distrust(liar, now_s);
    for (auto& [id, job] : jobs_)
        if (policy_.audit_fraction > 0 && job.record.begun && !job.record.over() && job.phase != Phase::storing)
            begin_retraction(job, liar);
    std::vector<SessionId> theirs;
    for (const auto& [id, session] : sessions_)
        if (session.worker() && session.machine() == liar) theirs.push_back(id);
    for (const SessionId id : theirs) {
        for (auto& [number, job] : jobs_) {
            if (!job.active) continue;
            Ledger& ledger = job.active->ledger();
            for (const LeaseId lease : ledger.leases_of(sessions_.at(id).instance())) ledger.release(lease);
        }
        send_off(id, wire::GoodbyeReason::refused, reason,
                 sentence + ": look at its memory; it is kept out until the master starts again", now_s);
    }
}

/// Where single results are not kept, or their kept hits depend on what the liar has sent, all goes. The record says so
/// first, so that a next life of the master does it, too.
void MasterCore::begin_retraction(Job& job, MachineId liar) {
    job.record.liars.push_back(liar);
    const bool all =
        !job.record.audited || (job.record.status.packing == Packing::maps && job.record.spec.keep_hits > 0);
    if (all) {
        job.record.distrusted = true;
        if (job.active) job.active->ledger().release_all();
        audits_.drop(job.record.id());
    }
    store_record(job);
}

/// When nothing that is to be retracted is on its way to the disk.
void MasterCore::retract_if_quiet(Job& job) {
    if (!has_liars(job) || !job.active || job.retracting || job.retraction_waits) return;
    const JobRecord& record = job.record;
    const std::set<MachineId> liars(record.liars.begin(), record.liars.end());
    const bool noisy = std::any_of(storing_.begin(), storing_.end(), [&](const auto& entry) {
        const Storing& storing = entry.second;
        return storing.job == record.id() && (record.distrusted || liars.contains(storing.machine));
    });
    if (noisy) return;
    job.retracting = true;
    JobRecord after = record;
    after.liars.clear();
    after.distrusted = false;
    effects_.push_back(Retract{std::move(after), liars, record.distrusted});
}

Effects MasterCore::on_retracted(const Retract& retract, Result<Retracted> left, double now_s) {
    Job* job = find(retract.record.id());
    if (!job || !job->active || !job->retracting) return settle_and_take(now_s);
    job->retracting = false;
    if (!left) {
        job->retraction_waits = true;
        await_space(left.error(), now_s);
        return settle_and_take(now_s);
    }
    job->active->retract(std::move(*left));
    job->committed_at.clear();
    std::erase_if(job->record.liars, [&](MachineId machine) { return retract.machines.contains(machine); });
    if (job->record.liars.empty()) job->record.distrusted = false;
    store_record(*job);
    return settle_and_take(now_s);
}

/// Whether the job waits for audits that somebody can still carry out.
bool MasterCore::is_questioned(const Job& job) {
    std::set<MachineId> able;
    for (const auto& [id, session] : sessions_)
        if (session.worker() && !session.is_relay() && !session.worker()->declined.contains(job.record.id()))
            able.insert(session.machine());
    count(Discard::audit_hopeless, audits_.drop_hopeless(job.record.id(), able));
    return audits_.pending(job.record.id()) > 0;
}

}  // namespace lumenfarm
