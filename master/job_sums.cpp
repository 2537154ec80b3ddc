#include "master/job_sums.h"

#include "common/support/ensure.h"
#include "proto/packing.h"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace lumenfarm {

JobSums::JobSums(const JobSpec& spec, std::shared_ptr<const PreparedJob> prepared)
    : spec_(spec),
      prepared_(std::move(prepared)),
      sums_(prepared_->layout),
      kept_(spec_.keep_hits),
      committed_(prepared_->particles.size()),
      flights_(prepared_->sources() - prepared_->particles.size()),
      ended_(flights_.subspaces()),
      work_times_{{}, std::vector<SubspaceCost>(flights_.subspaces())} {}

bool JobSums::is_there(const ParticleRange& range) const {
    if (range.source >= committed_.size() + flights_.subspaces()) return false;
    const std::uint64_t particles = range.source < committed_.size()
                                        ? prepared_->particles[range.source]
                                        : flights_.filed(range.source - static_cast<std::uint32_t>(committed_.size()));
    return range.first < particles && range.count <= particles - range.first;
}

bool JobSums::fits(const StagedResult& result) const {
    std::vector<IntervalSet> covered(prepared_->sources());
    const auto& claims = result.done().claims;
    const bool once = std::all_of(claims.begin(), claims.end(), [&](const wire::Claim& claim) {
        const ParticleRange& range = claim.range;
        const std::uint64_t end = range.first + range.count;
        return is_there(range) && !done(range.source).overlaps(range.first, end) &&
               covered[range.source].insert(range.first, end);
    });
    return once && result.closes_with(energy_of(flights_, *prepared_, claims));
}

std::vector<FlightQueues::Filed> JobSums::merge(const StagedResult& result) {
    std::vector<FlightQueues::Filed> filed;
    for (const wire::Message& message : result.messages())
        std::visit(
            [&]<class M>(const M& part) {
                if constexpr (requires { this->merge(part); }) this->merge(part);
                if constexpr (std::is_same_v<M, wire::ResultFlights>)
                    filed.push_back(flights_.file(part.subspace, part.flights));
            },
            message);
    return filed;
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

void JobSums::merge(const wire::ResultWork& part) {
    for (const SubspaceWork& each : part.work) {
        SubspaceCost& cost = work_times_.costs[each.subspace];
        cost.hits += each.hits;
        cost.nanoseconds = std::min(cost.nanoseconds + each.nanoseconds, wire::work_nanoseconds_max);
    }
}

void JobSums::merge(const wire::ResultDone& result) {
    const auto lights = static_cast<std::uint32_t>(committed_.size());
    for (const wire::Claim& claim : result.claims) {
        const ParticleRange& range = claim.range;
        ensure(done(range.source).insert(range.first, range.first + range.count), "a particle is merged once");
        if (range.source >= lights) flights_.remove(range.source - lights, range.first, range.count);
    }
    balance_ += result.balance;
    time_.trace_s += result.cpu_seconds;
}

Solution JobSums::take(const Digest& scene) {
    Solution solution;
    solution.scene = scene;
    solution.spec = spec_;
    solution.committed = std::move(committed_);
    solution.balance = balance_;
    solution.balance.cut_off += flights_.energy();
    solution.texels = std::move(sums_.texels());
    solution.surfaces = std::move(sums_.surfaces());
    solution.kept = kept_.sorted();
    solution.time = time_;
    return solution;
}

void JobSums::restore(Solution solution, FlightQueues flights, std::vector<IntervalSet> ended, WorkTimes work_times) {
    flights_ = std::move(flights);
    ended_ = std::move(ended);
    work_times_ = std::move(work_times);
    restore(std::move(solution));
}

void JobSums::restore(Solution solution) {
    committed_ = std::move(solution.committed);
    balance_ = solution.balance;
    balance_.cut_off -= flights_.energy();
    sums_.texels() = std::move(solution.texels);
    sums_.surfaces() = std::move(solution.surfaces);
    kept_ = KeptHits(spec_.keep_hits);
    for (const KeptHit& hit : solution.kept) kept_.offer(hit);
    time_ = solution.time;
}

void JobSums::file_by(const Partition& cut, std::optional<CutLesson> lesson) {
    std::vector<FlightQueues::Flights> filed(flights_.subspaces());
    for (std::uint32_t subspace = 0; subspace < flights_.subspaces(); ++subspace)
        for (const auto& gap : ended_[subspace].gaps(0, flights_.filed(subspace)))
            for (const wire::FlightRecord& record : flights_.at(subspace, gap.begin, gap.end - gap.begin)) {
                const Flight flight = wire::unpack_flight(record);
                filed[cut.at(flight.origin, flight.direction, flight.travelled_m).subspace].push_back(record);
            }
    flights_ = FlightQueues(filed.size());
    ended_.assign(filed.size(), {});
    work_times_.costs.assign(filed.size(), {});
    if (lesson) work_times_.lessons.push_back(std::move(*lesson));
    for (std::uint32_t subspace = 0; subspace < filed.size(); ++subspace)
        if (!filed[subspace].empty()) flights_.file(subspace, std::move(filed[subspace]));
}

std::uint64_t JobSums::bytes() const {
    const std::uint64_t bytes_of_lesson =
        flights_.subspaces() * (sizeof(double) + 2 * sizeof(Partition::Node) + sizeof(SubspaceCost));
    return sums_.texels().size() * sizeof(TexelSums) + sums_.surfaces().size() * sizeof(SurfaceBatches) +
           std::min<std::uint64_t>(spec_.keep_hits, balance_.hits) * sizeof(KeptHit) +
           flights_.count() * sizeof(wire::FlightRecord) + (1 + work_times_.lessons.size()) * bytes_of_lesson;
}

}  // namespace lumenfarm
