#include "master/ledger.h"

/// The ledger's books, looked through.
namespace lumenfarm {

namespace {

IntervalSet::Interval interval_of(const ParticleRange& range) { return {range.first, range.first + range.count}; }

std::string of_source(std::uint32_t source, const IntervalSet::Interval& piece) {
    return "particles " + std::to_string(piece.begin) + " to " + std::to_string(piece.end) + " of source " +
           std::to_string(source);
}

}  // namespace

std::optional<std::string> Ledger::contradiction() const {
    std::vector<IntervalSet> found = arrived_;
    const auto twice = [&](std::uint32_t source, const IntervalSet::Interval& piece) {
        return piece.end > shares_[source].particles || !found[source].insert(piece.begin, piece.end);
    };
    std::size_t held_by_workers = 0;
    for (const auto& [worker, leases] : leases_by_worker_) held_by_workers += leases.size();
    if (held_by_workers != leases_.size())
        return std::to_string(held_by_workers) + " leases are workers', of " + std::to_string(leases_.size());
    for (const auto& [id, lease] : leases_) {
        if (!held(lease.worker).contains(id)) return "lease " + std::to_string(id) + " is not its worker's";
        IntervalSet shared;  // what two leases may owe: a straggler's and its twin's
        const auto twin = leases_.find(lease.twin);
        if (twin != leases_.end() && twin->first < id)
            for (const auto& piece : twin->second.owed) shared.insert(piece.begin, piece.end);
        for (const auto& owed : lease.owed)
            for (const auto& piece : shared.gaps(owed.begin, owed.end))
                if (twice(lease.source, piece))
                    return of_source(lease.source, piece) + " are leased and elsewhere, too";
    }
    for (const LostSet& lost : lost_.waiting())
        if (const auto piece = interval_of(lost.range); twice(lost.range.source, piece))
            return of_source(lost.range.source, piece) + " wait after a loss and are elsewhere, too";
    for (const LostSet& aside : lost_.set_aside())
        if (const auto piece = interval_of(aside.range); twice(aside.range.source, piece))
            return of_source(aside.range.source, piece) + " are set aside and elsewhere, too";
    std::uint64_t free = 0, queued = 0, committed = 0;
    for (std::uint32_t source = 0; source < shares_.size(); ++source) {
        const Share& share = shares_[source];
        const std::uint64_t bound = found[source].size();
        for (const auto& piece : share.returned)
            if (twice(source, piece)) return of_source(source, piece) + " are free and elsewhere, too";
        if (share.next < share.particles && twice(source, {share.next, share.particles}))
            return of_source(source, {share.next, share.particles}) + " are free and elsewhere, too";
        for (const auto& piece : committed_by_source_[source].intervals())
            if (!arrived_[source].covers(piece.begin, piece.end))
                return of_source(source, piece) + " are committed and have not arrived";
        if (found[source].size() != share.particles)
            return std::to_string(share.particles - found[source].size()) + " particles of source " +
                   std::to_string(source) + " are lost";
        free += share.particles - bound;
        queued += is_light(source) ? 0 : share.particles - bound;
        committed += committed_by_source_[source].size();
    }
    if (free != unleased_) return std::to_string(free) + " particles are free, not " + std::to_string(unleased_);
    if (queued != queued_) return std::to_string(queued) + " particles wait in queues, not " + std::to_string(queued_);
    if (committed != committed_.in_all())
        return std::to_string(committed) + " particles are committed, not " + std::to_string(committed_.in_all());
    return std::nullopt;
}

}  // namespace lumenfarm
