#include "master/active_job.h"

#include <utility>
#include <vector>

namespace lumenfarm {

namespace {

std::vector<Claim> claims_of(const wire::ResultDone& done) {
    std::vector<Claim> claims;
    claims.reserve(done.claims.size());
    for (const wire::Claim& covered : done.claims) claims.push_back({covered.lease, covered.range});
    return claims;
}

Outcome outcome_of(ClaimVerdict verdict) {
    switch (verdict) {
        case ClaimVerdict::current: return {};
        case ClaimVerdict::stale: return {wire::Verdict::stale, "a lease of the result is not current any more"};
        case ClaimVerdict::already_committed: return {wire::Verdict::already_merged, "its particles are committed"};
        case ClaimVerdict::invalid: break;
    }
    return {wire::Verdict::invalid, "the result covers particles that its leases do not hold"};
}

}  // namespace

ActiveJob::ActiveJob(const JobSpec& spec, std::shared_ptr<const PreparedJob> prepared)
    : spec_(spec),
      prepared_(std::move(prepared)),
      packing_(packing_in_force(spec_, *prepared_)),
      ledger_(prepared_->particles),
      sums_(prepared_->scene, prepared_->layout),
      kept_(spec_.keep_hits) {}

Outcome ActiveJob::commit(WorkerId worker, const StagedResult& result, const wire::ResultDone& done) {
    const std::vector<Claim> claims = claims_of(done);
    Outcome outcome = outcome_of(ledger_.check(worker, claims));
    if (const auto checked = result.check(done); !checked) outcome = {wire::Verdict::invalid, checked.error().sentence};
    if (outcome.verdict != wire::Verdict::accepted) {
        // the worker forgets the whole result, so its leases are taken back
        for (const Claim& claim : claims)
            if (ledger_.held_by(worker, claim.lease)) ledger_.release(claim.lease);
        return outcome;
    }
    ledger_.commit(claims);
    for (const wire::ResultHits& part : result.hits()) merge(part);
    for (const wire::ResultMap& part : result.maps()) merge(part);
    for (const wire::ResultKept& part : result.kept())
        for (const KeptHit& hit : part.hits) kept_.offer(hit);
    balance_ += done.balance;
    time_.trace_s += done.trace_seconds;
    return outcome;
}

void ActiveJob::merge(const wire::ResultHits& part) {
    const Emission& emission = prepared_->emission;
    sums_.add(emission, part.light, part.records, part.energies);
    if (kept_.capacity() == 0) return;
    for (std::size_t i = 0; i < part.records.size(); ++i) {
        const HitRecord& record = part.records[i];
        const std::uint32_t energy =
            part.energies.empty() ? emission.lights[part.light].energy[record.wavelength] : part.energies[i];
        kept_.offer({record, part.light, energy});
    }
}

void ActiveJob::merge(const wire::ResultMap& part) {
    for (const wire::TexelDelta& delta : part.texels)
        sums_.texels()[delta.texel] += {delta.radiant, delta.x, delta.y, delta.z, delta.y_squared, delta.hits};
    for (const wire::SurfaceDelta& delta : part.surfaces)
        sums_.surfaces()[delta.surface][delta.side()][delta.batch()] += {delta.radiant, delta.y, delta.hits};
}

std::shared_ptr<const Solution> ActiveJob::take_solution(const Digest& scene, std::uint32_t workers, double total_s) {
    auto solution = std::make_shared<Solution>();
    solution->scene = scene;
    solution->spec = spec_;
    solution->committed = ledger_.committed();
    solution->balance = balance_;
    solution->texels = std::move(sums_.texels());
    solution->surfaces = std::move(sums_.surfaces());
    solution->kept = kept_.sorted();
    solution->time = time_;
    solution->time.total_s = total_s;
    solution->time.workers = workers;
    return solution;
}

}  // namespace lumenfarm
