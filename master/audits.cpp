#include "master/audits.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <utility>

namespace lumenfarm {

void Audits::begin(JobId job, MachineId machine, std::span<const ParticleRange> ranges, double now_s, double patience_s,
                   std::uint64_t keep_threshold, std::uint64_t fingerprint) {
    Audit audit;
    audit.job = job;
    audit.ranges.assign(ranges.begin(), ranges.end());
    for (const ParticleRange& range : ranges) audit.particles += range.count;
    audit.patience_s = patience_s;
    audit.begun_s = audit.waits_since_s = now_s;
    audit.keep_threshold = keep_threshold;
    audit.said.emplace(machine, fingerprint);
    audits_.emplace(++begun_, std::move(audit));
}

bool Audits::has_set(const Audit& audit, MachineId machine) {
    if (audit.witness) return audit.witness->machine == machine && audit.witness->next < audit.ranges.size();
    return audit.may_begin(machine);
}

bool Audits::has_set(JobId job, MachineId machine) const {
    return std::any_of(audits_.begin(), audits_.end(),
                       [&](const auto& entry) { return entry.second.job == job && has_set(entry.second, machine); });
}

Audits::Set Audits::give(JobId job, MachineId machine, LeaseId id, double now_s) {
    const auto found = std::find_if(audits_.begin(), audits_.end(), [&](const auto& entry) {
        return entry.second.job == job && has_set(entry.second, machine);
    });
    ensure(found != audits_.end() && !given_.contains(id), "there is a set to audit, and its lease is new");
    Audit& audit = found->second;
    if (!audit.witness) audit.witness = Witness{machine, now_s, 0, 0, audit.particles};
    const ParticleRange range = audit.ranges[audit.witness->next++];
    given_.emplace(id, Given{found->first, machine, range.source, {}, range});
    return {found->first, range, audit.keep_threshold};
}

std::optional<AuditId> Audits::check(MachineId machine, std::span<const Claim> claims) const {
    std::optional<AuditId> audit;
    std::map<LeaseId, IntervalSet> covered;
    for (const Claim& claim : claims) {
        const auto found = given_.find(claim.lease);
        if (found == given_.end() || found->second.machine != machine) return std::nullopt;
        const Given& given = found->second;
        if (audit && *audit != given.audit) return std::nullopt;
        audit = given.audit;
        const std::uint64_t end = claim.range.first + claim.range.count;
        const bool inside = claim.range.source == given.light && claim.range.first >= given.range.first &&
                            end <= given.range.first + given.range.count;
        if (!inside || given.done.overlaps(claim.range.first, end)) return std::nullopt;
        if (!covered[claim.lease].insert(claim.range.first, end)) return std::nullopt;
    }
    return audit;
}

std::optional<Audits::Finding> Audits::take(AuditId id, std::span<const Claim> claims, std::uint64_t fingerprint) {
    Audit& audit = audits_.at(id);
    Witness& witness = *audit.witness;
    witness.fingerprint += fingerprint;
    for (const Claim& claim : claims) {
        Given& given = given_.at(claim.lease);
        ensure(given.done.insert(claim.range.first, claim.range.first + claim.range.count), "a claim is owed");
        witness.owed -= claim.range.count;
        if (given.done.size() == given.range.count) given_.erase(claim.lease);
    }
    if (witness.owed > 0) return std::nullopt;
    audit.said.emplace(witness.machine, witness.fingerprint);
    audit.witness.reset();
    auto found = finding(audit);
    if (found) erase(id);
    return found;
}

std::optional<Audits::Finding> Audits::finding(const Audit& audit) {
    for (const auto& [machine, said] : audit.said) {
        Finding finding;
        for (const auto& [other, theirs] : audit.said)
            (theirs == said ? finding.honest : finding.liars).push_back(other);
        if (finding.honest.size() >= 2) return finding;
    }
    return std::nullopt;
}

/// Of its witness.
void Audits::dismiss(AuditId id, double now_s) {
    Audit& audit = audits_.at(id);
    if (!audit.witness) return;
    audit.witness.reset();
    audit.waits_since_s = now_s;
    std::erase_if(given_, [&](const auto& entry) { return entry.second.audit == id; });
}

void Audits::erase(AuditId id) {
    dismiss(id, 0);
    audits_.erase(id);
}

void Audits::forget(MachineId machine, double now_s) {
    for (auto& [id, audit] : audits_)
        if (audit.witness && audit.witness->machine == machine) dismiss(id, now_s);
}

void Audits::forget(MachineId machine, LeaseId only, double now_s) {
    const auto found = given_.find(only);
    if (found == given_.end() || found->second.machine != machine) return;
    const AuditId id = found->second.audit;
    audits_.at(id).given_up.insert(machine);
    dismiss(id, now_s);
}

bool Audits::busy(MachineId machine) const {
    return std::any_of(given_.begin(), given_.end(),
                       [&](const auto& entry) { return entry.second.machine == machine; });
}

void Audits::interrupt(JobId job, double now_s) {
    for (auto& [id, audit] : audits_) {
        if (audit.job != job) continue;
        dismiss(id, now_s);
        audit.given_up.clear();
    }
}

void Audits::distrust(MachineId machine, double now_s) {
    forget(machine, now_s);
    for (auto it = audits_.begin(); it != audits_.end();) {
        auto& [id, audit] = *it++;
        audit.said.erase(machine);
        if (audit.said.empty()) erase(AuditId{id});
    }
}

std::uint64_t Audits::expire(double now_s) {
    std::uint64_t dropped = 0;
    for (auto it = audits_.begin(); it != audits_.end();) {
        auto& [id, audit] = *it++;
        // a witness that dies gives its place to the next, and so on
        if (!audit.disputed() && now_s > audit.begun_s + limits::audit_patiences_max * audit.patience_s) {
            erase(AuditId{id});
            ++dropped;
            continue;
        }
        const double since_s = audit.witness ? audit.witness->begun_s : audit.waits_since_s;
        if (now_s <= since_s + audit.patience_s) continue;
        if (audit.witness) {
            audit.given_up.insert(audit.witness->machine);
            dismiss(id, now_s);
        } else if (audit.disputed()) {
            audit.given_up.clear();
            audit.waits_since_s = now_s;
        } else {
            erase(AuditId{id});
            ++dropped;
        }
    }
    return dropped;
}

template <class Wanted>
std::uint64_t Audits::drop_if(JobId job, Wanted wanted) {
    std::uint64_t dropped = 0;
    for (auto it = audits_.begin(); it != audits_.end();) {
        const auto& [id, audit] = *it++;
        if (audit.job != job || !wanted(audit)) continue;
        erase(AuditId{id});
        ++dropped;
    }
    return dropped;
}

std::uint64_t Audits::drop(JobId job) {
    return drop_if(job, [](const Audit&) { return true; });
}

std::uint64_t Audits::drop_undisputed(JobId job) {
    return drop_if(job, [](const Audit& audit) { return !audit.disputed(); });
}

std::uint64_t Audits::drop_hopeless(JobId job, const std::set<MachineId>& able) {
    return drop_if(job, [&](const Audit& audit) {
        return !audit.witness && !audit.disputed() &&
               std::none_of(able.begin(), able.end(), [&](MachineId machine) { return audit.may_begin(machine); });
    });
}

std::uint64_t Audits::pending(JobId job) const {
    return static_cast<std::uint64_t>(
        std::count_if(audits_.begin(), audits_.end(), [&](const auto& entry) { return entry.second.job == job; }));
}

std::uint64_t Audits::disputed(JobId job) const {
    return static_cast<std::uint64_t>(std::count_if(audits_.begin(), audits_.end(), [&](const auto& entry) {
        return entry.second.job == job && entry.second.disputed();
    }));
}

}  // namespace lumenfarm
