#include "master/active_job.h"

#include <algorithm>
#include <utility>

namespace lumenfarm {

namespace {

Outcome outcome_of(ClaimVerdict verdict) {
    switch (verdict) {
        case ClaimVerdict::current:
        case ClaimVerdict::being_stored: return {};
        case ClaimVerdict::stale: return {wire::Verdict::stale, "a lease of the result is not current any more"};
        case ClaimVerdict::already_committed: return {wire::Verdict::already_merged, "particles of it are committed"};
        case ClaimVerdict::invalid: break;
    }
    return {wire::Verdict::invalid, "the result covers particles that its leases do not hold"};
}

/// The epoch is a part of a lease's id, so that a lease of an earlier life is never taken for one of this.
bool of_their_epochs(const wire::ResultDone& done) {
    return std::all_of(done.claims.begin(), done.claims.end(),
                       [](const wire::Claim& claim) { return epoch_of(claim.lease) == claim.epoch; });
}

std::vector<std::uint64_t> particles_by_source(const PreparedJob& prepared, const FlightQueues& flights) {
    std::vector<std::uint64_t> particles = prepared.particles;
    for (std::uint32_t subspace = 0; subspace < flights.subspaces(); ++subspace)
        particles.push_back(flights.filed(subspace));
    return particles;
}

}  // namespace

std::vector<Claim> claims_of(const wire::ResultDone& done) {
    std::vector<Claim> claims;
    claims.reserve(done.claims.size());
    for (const wire::Claim& covered : done.claims) claims.push_back({covered.lease, covered.range});
    return claims;
}

ActiveJob::ActiveJob(const JobSpec& spec, RecoveredJob recovered, double now_s, double deadline_s)
    : prepared_(std::move(recovered.prepared)),
      files_(std::move(recovered.files)),
      packing_(packing_in_force(spec, *prepared_)),
      flights_(std::move(recovered.flights)),
      ledger_(particles_by_source(*prepared_, flights_), prepared_->particles.size(), std::move(recovered.committed),
              recovered.leases, now_s, deadline_s),
      balance_(recovered.balance),
      trace_cpu_s_(recovered.trace_cpu_s),
      earlier_effort_(recovered.effort),
      keep_threshold_(recovered.keep_threshold) {}

std::optional<Outcome> ActiveJob::take(WorkerId worker, StagedResult& result, wire::ResultDone done) {
    const std::vector<Claim> claims = claims_of(done);
    const ClaimVerdict verdict = of_their_epochs(done) ? ledger_.check(worker, claims) : ClaimVerdict::stale;
    if (verdict == ClaimVerdict::being_stored) return std::nullopt;
    Outcome outcome = outcome_of(verdict);
    if (const auto whole = result.complete(*prepared_, std::move(done)); !whole)
        outcome = {result.blameless() ? wire::Verdict::stale : wire::Verdict::invalid, whole.error().sentence};
    else if (outcome.verdict == wire::Verdict::accepted &&
             !result.closes_with(energy_of(flights_, *prepared_, result.done().claims)))
        outcome = {wire::Verdict::invalid, "the energy balance does not close with the particles in flight"};
    if (outcome.verdict == wire::Verdict::accepted) {
        ledger_.store(claims);
        return outcome;
    }
    take_back(worker, claims);
    return outcome;
}

void ActiveJob::take_back(WorkerId worker, std::span<const Claim> claims) {
    for (const Claim& claim : claims)
        if (ledger_.held_by(worker, claim.lease)) ledger_.release(claim.lease);
}

void ActiveJob::retract(Retracted left) {
    if (prepared_->subspaces) {
        // what was filed may come from what is retracted: all begins anew
        flights_ = FlightQueues(flights_.subspaces());
        ledger_.restart();
    } else {
        ledger_.retract(std::move(left.committed));
    }
    balance_ = left.balance;
    trace_cpu_s_ = left.trace_cpu_s;
    keep_threshold_ = left.keep_threshold;
}

bool ActiveJob::may_lend(const ParticleRange& range) const {
    const auto lights = static_cast<std::uint32_t>(prepared_->particles.size());
    return ledger_.may_lend(range) &&
           (range.source < lights || flights_.may_lend(range.source - lights, range.first, range.count));
}

void ActiveJob::lend(const ParticleRange& range, FlightQueues::Flights flights) {
    const auto lights = static_cast<std::uint32_t>(prepared_->particles.size());
    ledger_.lend(range);
    if (range.source < lights) return;
    flights_.lend(
        {range.source - lights, range.first, std::make_shared<const FlightQueues::Flights>(std::move(flights))});
}

void ActiveJob::withdraw(const ParticleRange& range) {
    const auto lights = static_cast<std::uint32_t>(prepared_->particles.size());
    for (const IntervalSet::Interval& piece : ledger_.withdraw(range))
        if (range.source >= lights) flights_.remove(range.source - lights, piece.begin, piece.end - piece.begin);
}

void ActiveJob::file(const FlightQueues::Filed& filed) {
    flights_.add(filed);
    ledger_.grow(static_cast<std::uint32_t>(prepared_->particles.size()) + filed.subspace, filed.flights->size());
}

FlightQueues::Flights ActiveJob::flights(const ParticleRange& range) const {
    const auto lights = static_cast<std::uint32_t>(prepared_->particles.size());
    if (range.source < lights) return {};
    return flights_.at(range.source - lights, range.first, range.count);
}

void ActiveJob::commit(const StagedResult& result) {
    const auto lights = static_cast<std::uint32_t>(prepared_->particles.size());
    ledger_.commit(claims_of(result.done()));
    for (const wire::Claim& claim : result.done().claims)
        if (claim.range.source >= lights)
            flights_.remove(claim.range.source - lights, claim.range.first, claim.range.count);
    balance_ += result.done().balance;
    trace_cpu_s_ += result.done().cpu_seconds;
}

}  // namespace lumenfarm
