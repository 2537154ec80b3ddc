#include "master/job_sums.h"

#include "common/support/ensure.h"
#include "proto/packing.h"

#include <algorithm>
#include <utility>

namespace lumenfarm {

JobSums::JobSums(const JobSpec& spec, std::shared_ptr<const PreparedJob> prepared)
    : spec_(spec),
      prepared_(std::move(prepared)),
      sums_(prepared_->scene, prepared_->layout),
      kept_(spec_.keep_hits),
      committed_(prepared_->particles.size()) {}

bool JobSums::fits(const StagedResult& result) const {
    std::vector<IntervalSet> covered(committed_.size());
    const auto& claims = result.done().claims;
    return std::all_of(claims.begin(), claims.end(), [&](const wire::Claim& claim) {
        const ParticleRange& range = claim.range;
        if (range.light >= committed_.size()) return false;
        const std::uint64_t particles = prepared_->particles[range.light];
        if (range.first >= particles || range.count > particles - range.first) return false;
        const std::uint64_t end = range.first + range.count;
        return !committed_[range.light].overlaps(range.first, end) && covered[range.light].insert(range.first, end);
    });
}

void JobSums::merge(const StagedResult& result) {
    for (const wire::Message& message : result.messages())
        std::visit(
            [&]<class M>(const M& part) {
                if constexpr (requires { this->merge(part); }) this->merge(part);
            },
            message);
}

void JobSums::merge(const wire::ResultHits& part) {
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

void JobSums::merge(const wire::ResultMap& part) { wire::add_map(part, sums_.texels(), sums_.surfaces()); }

void JobSums::merge(const wire::ResultKept& part) {
    for (const KeptHit& hit : part.hits) kept_.offer(hit);
}

void JobSums::merge(const wire::ResultDone& done) {
    for (const wire::Claim& claim : done.claims) {
        const ParticleRange& range = claim.range;
        ensure(committed_[range.light].insert(range.first, range.first + range.count), "a particle is merged once");
    }
    balance_ += done.balance;
    time_.trace_s += done.trace_seconds;
}

Solution JobSums::take(const Digest& scene) {
    Solution solution;
    solution.scene = scene;
    solution.spec = spec_;
    solution.committed = std::move(committed_);
    solution.balance = balance_;
    solution.texels = std::move(sums_.texels());
    solution.surfaces = std::move(sums_.surfaces());
    solution.kept = kept_.sorted();
    solution.time = time_;
    return solution;
}

void JobSums::restore(Solution solution) {
    committed_ = std::move(solution.committed);
    balance_ = solution.balance;
    sums_.texels() = std::move(solution.texels);
    sums_.surfaces() = std::move(solution.surfaces);
    kept_ = KeptHits(spec_.keep_hits);
    for (const KeptHit& hit : solution.kept) kept_.offer(hit);
    time_ = solution.time;
}

std::uint64_t JobSums::bytes() const {
    return sums_.texels().size() * sizeof(TexelSums) + sums_.surfaces().size() * sizeof(SurfaceBatches) +
           std::min<std::uint64_t>(spec_.keep_hits, balance_.hits) * sizeof(KeptHit);
}

}  // namespace lumenfarm
