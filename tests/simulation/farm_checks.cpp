#include "tests/simulation/farm_checks.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::testing {

namespace {

std::string named(JobId job, std::uint32_t source, std::uint64_t begin, std::uint64_t end) {
    return "particles " + std::to_string(begin) + " to " + std::to_string(end) + " of source " +
           std::to_string(source) + " of job " + std::to_string(job);
}

}  // namespace

std::uint64_t committed_in_all(const Ledger& ledger) {
    std::uint64_t committed = 0;
    for (const IntervalSet& source : ledger.committed()) committed += source.size();
    return committed;
}

void FarmChecks::violated(std::string sentence) {
    world_.note(Who::farm, 0, "VIOLATION");
    violations_.push_back(std::move(sentence));
}

IntervalSet& FarmChecks::acknowledged(JobId job, std::uint32_t light) {
    auto& lights = acknowledged_[job];
    lights.resize(std::max<std::size_t>(lights.size(), light + 1));
    return lights[light];
}

std::optional<JobId> FarmChecks::job_of(std::uint64_t client) const {
    const auto found = promised_.find(client);
    return found == promised_.end() ? std::nullopt : std::optional(found->second);
}

// Lives of the master

void FarmChecks::on_master_start(const Storage::Start& start) {
    for (const std::string& warning : start.warnings) violated(warning);
    const auto record_of = [&](JobId job) {
        return std::find_if(start.records.begin(), start.records.end(),
                            [job](const JobRecord& record) { return record.id() == job; });
    };
    for (const auto& [client, job] : promised_)
        if (record_of(job) == start.records.end())
            violated("job " + std::to_string(job) + " was promised, and is gone");
    if (!violations_.empty()) return;
    for (const JobId job : cancelled_)
        if (const auto record = record_of(job); !record->cancel_asked && !record->over())
            violated("the end of job " + std::to_string(job) + " was promised, and is forgotten");
    for (const auto& [job, end] : ends_)
        if (const auto record = record_of(job); End{record->status.state, record->status.digest} != end)
            violated("job " + std::to_string(job) + " has another end than was told");
}

void FarmChecks::on_master_end() {
    present_.clear();
    held_.clear();
    committed_.clear();
}

void FarmChecks::on_recovered(const JobRecord& record, const RecoveredJob& recovered) {
    const JobId job = record.id();
    // it was cancelled with particles in flight, and extended
    if (!record.begun && record.spec.strategy == Strategy::subspaces) acknowledged_.erase(job);
    for (const std::string& damage : recovered.damages) violated(damage);
    auto& sources = acknowledged_[job];
    // a job that was over goes on from its solution, with nothing in flight: flights are numbered from 0 again
    bool in_flight = false;
    for (std::uint32_t subspace = 0; subspace < recovered.flights.subspaces(); ++subspace)
        in_flight = in_flight || recovered.flights.filed(subspace) > 0;
    // so they are where subspaces were cut anew, which gives another plan
    const Digest plan = std::exchange(plans_[job], recovered.files.first);
    if (plan != recovered.files.first) in_flight = false;
    recuts_ += recovered.recut.has_value();
    if (!in_flight) {
        sources.resize(std::min(sources.size(), recovered.prepared->particles.size()));
        committed_.erase(job);
    }
    for (std::uint32_t source = 0; source < sources.size(); ++source)
        for (const auto& piece : sources[source].intervals())
            if (!recovered.committed[source].covers(piece.begin, piece.end))
                violated(named(job, source, piece.begin, piece.end) + " were acknowledged, and are gone");
}

void FarmChecks::on_retracted(const Retract& retract, const Retracted& left) {
    world_.note(Who::master, 0, "retracts what liars have traced of the job", {retract.record.id()});
    if (!somebody_lies_) violated("an honest worker is called a liar");
    auto& lights = acknowledged_[retract.record.id()];
    const std::vector<IntervalSet::Interval> nothing;  // is left of what was in flight
    for (std::size_t light = 0; light < lights.size(); ++light) {
        IntervalSet kept;
        for (const auto& piece : lights[light].intervals())
            for (const auto& still : light < left.committed.size() ? left.committed[light].intervals() : nothing)
                if (const auto begin = std::max(piece.begin, still.begin), end = std::min(piece.end, still.end);
                    begin < end)
                    kept.insert(begin, end);
        lights[light] = std::move(kept);
    }
    committed_[retract.record.id()] = left.balance.particles;
}

// What the master says

void FarmChecks::on_sent(const MasterCore& core, std::uint64_t to, const wire::Message& message) {
    if (const auto* lease = std::get_if<wire::Lease>(&message)) {
        on_lease(*lease);
    } else if (const auto* ack = std::get_if<wire::ResultAck>(&message)) {
        on_ack(core, to, *ack);
    } else if (const auto* submitted = std::get_if<wire::SubmitReply>(&message)) {
        if (submitted->job != 0) on_promise(to, submitted->job);
    } else if (const auto* control = std::get_if<wire::ControlReply>(&message)) {
        if (control->state == wire::JobState::cancelled) cancelled_.insert(control->job);
    } else if (const auto* status = std::get_if<wire::StatusReply>(&message)) {
        for (const wire::JobStatus& job : status->jobs) on_status(job);
    }
}

void FarmChecks::on_lease(const wire::Lease& lease) {
    const ParticleRange& range = lease.range;
    world_.note(Who::master, lease.epoch, "leases (job, light, first, count)",
                {lease.job, range.source, range.first, range.count});
    if (lease.audit != 0) {
        audit_leases_.insert(lease.lease);
        return;
    }
    if (acknowledged(lease.job, range.source).overlaps(range.first, range.first + range.count))
        violated(named(lease.job, range.source, range.first, range.first + range.count) +
                 " are leased again after they were acknowledged");
}

void FarmChecks::on_ack(const MasterCore& core, WorkerId worker, const wire::ResultAck& ack) {
    world_.note(Who::master, worker, "answers the worker (result, verdict)",
                {ack.result, static_cast<std::uint64_t>(ack.verdict)});
    if (ack.verdict == wire::Verdict::invalid) violated("an honest result is called impossible: " + ack.sentence);
    if (ack.verdict != wire::Verdict::accepted) return;
    const auto offer = offers_.extract({worker, ack.result});
    if (offer.empty()) return violated("a result is accepted twice, or was never offered");
    if (audit_leases_.contains(offer.mapped().claims.front().lease)) return;  // nothing is committed
    const Ledger* ledger = core.ledger(offer.mapped().job);
    for (const wire::Claim& claim : offer.mapped().claims) {
        const ParticleRange& range = claim.range;
        const std::uint64_t end = range.first + range.count;
        const std::string name = named(ack.job, range.source, range.first, end);
        if (!acknowledged(ack.job, range.source).insert(range.first, end)) violated(name + " are committed twice");
        if (ledger && !ledger->committed()[range.source].covers(range.first, end))
            violated(name + " are acknowledged, and not committed");
    }
}

void FarmChecks::on_promise(std::uint64_t client, JobId job) {
    const auto [known, fresh] = promised_.emplace(client, job);
    if (known->second != job) violated("one key has become two jobs");
    if (!fresh) return;
    const bool others = std::any_of(promised_.begin(), promised_.end(),
                                    [&](const auto& other) { return other.first != client && other.second == job; });
    if (others) violated("two keys have become one job");
}

void FarmChecks::on_status(const wire::JobStatus& status) {
    if (!wire::is_over(status.state)) {
        if (ends_.contains(status.job)) violated("job " + std::to_string(status.job) + " was over, and is not");
        return;
    }
    const auto [known, fresh] = ends_.emplace(status.job, End{status.state, status.digest});
    if (known->second != End{status.state, status.digest})
        violated("job " + std::to_string(status.job) + " has another end than was told");
}

// Steps

void FarmChecks::before_tick(const MasterCore& core) {
    held_.clear();
    expired_ = core.discarded(Discard::lease_expired);
    for (JobId job = 1; job <= jobs_; ++job) {
        const Ledger* ledger = core.ledger(job);
        if (!ledger) continue;
        for (const WorkerId worker : present_)
            for (const LeaseId lease : ledger->leases_of(worker)) held_.push_back({job, lease, worker});
    }
}

void FarmChecks::after_tick(const MasterCore& core) {
    if (core.discarded(Discard::lease_expired) == expired_) return;
    world_.note(Who::master, 0, "leases expire", {core.discarded(Discard::lease_expired) - expired_});
    for (const HeldLease& held : held_) {
        const Ledger* ledger = core.ledger(held.job);
        if (ledger && !ledger->holds(held.lease))
            violated("lease " + std::to_string(held.lease) + " expired while its worker was there");
    }
}

void FarmChecks::after_event(const MasterCore& core) {
    if (const auto fault = core.contradiction()) violated(*fault);
    for (JobId job = 1; job <= jobs_; ++job) {
        const Ledger* ledger = core.ledger(job);
        if (!ledger) continue;
        std::uint64_t acknowledged = 0;
        for (const IntervalSet& light : acknowledged_[job]) acknowledged += light.size();
        if (committed_in_all(*ledger) < std::max(committed_[job], acknowledged))
            violated("particles of job " + std::to_string(job) + " were committed, and are not");
        committed_[job] = committed_in_all(*ledger);
    }
}

}  // namespace lumenfarm::testing
