#include "master/ledger.h"

/// The ledger's books, looked through.
namespace lumenfarm {

namespace {

IntervalSet::Interval interval_of(const ParticleRange& range) { return {range.first, range.first + range.count}; }

std::string of_light(std::uint32_t light, const IntervalSet::Interval& piece) {
    return "particles " + std::to_string(piece.begin) + " to " + std::to_string(piece.end) + " of light " +
           std::to_string(light);
}

}  // namespace

std::optional<std::string> Ledger::contradiction() const {
    std::vector<IntervalSet> found = arrived_;
    const auto twice = [&](std::uint32_t light, const IntervalSet::Interval& piece) {
        return piece.end > shares_[light].particles || !found[light].insert(piece.begin, piece.end);
    };
    for (const auto& [id, lease] : leases_) {
        IntervalSet shared;  // what two leases may owe: a straggler's and its twin's
        const auto twin = leases_.find(lease.twin);
        if (twin != leases_.end() && twin->first < id)
            for (const auto& piece : twin->second.owed) shared.insert(piece.begin, piece.end);
        for (const auto& owed : lease.owed)
            for (const auto& piece : shared.gaps(owed.begin, owed.end))
                if (twice(lease.light, piece)) return of_light(lease.light, piece) + " are leased and elsewhere, too";
    }
    for (const LostSet& lost : lost_.waiting())
        if (const auto piece = interval_of(lost.range); twice(lost.range.light, piece))
            return of_light(lost.range.light, piece) + " wait after a loss and are elsewhere, too";
    for (const LostSet& aside : lost_.set_aside())
        if (const auto piece = interval_of(aside.range); twice(aside.range.light, piece))
            return of_light(aside.range.light, piece) + " are set aside and elsewhere, too";
    std::uint64_t free = 0, committed = 0;
    for (std::uint32_t light = 0; light < shares_.size(); ++light) {
        const LightShare& share = shares_[light];
        const std::uint64_t bound = found[light].size();
        for (const auto& piece : share.returned)
            if (twice(light, piece)) return of_light(light, piece) + " are free and elsewhere, too";
        if (share.next < share.particles && twice(light, {share.next, share.particles}))
            return of_light(light, {share.next, share.particles}) + " are free and elsewhere, too";
        for (const auto& piece : committed_[light].intervals())
            if (!arrived_[light].covers(piece.begin, piece.end))
                return of_light(light, piece) + " are committed and have not arrived";
        if (found[light].size() != share.particles)
            return std::to_string(share.particles - found[light].size()) + " particles of light " +
                   std::to_string(light) + " are lost";
        free += share.particles - bound;
        committed += committed_[light].size();
    }
    if (free != unleased_) return std::to_string(free) + " particles are free, not " + std::to_string(unleased_);
    if (committed != committed_particles_)
        return std::to_string(committed) + " particles are committed, not " + std::to_string(committed_particles_);
    return std::nullopt;
}

}  // namespace lumenfarm
