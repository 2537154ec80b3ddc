#include "relay/lent_sets.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <iterator>

namespace lumenfarm::relay {

namespace {

std::uint64_t end_of(const ParticleRange& range) { return range.first + range.count; }

}  // namespace

std::vector<LentSet> LentSets::across(const ParticleRange& range) const {
    std::vector<LentSet> found;
    auto at = sets_.lower_bound({range.source, end_of(range)});
    while (at != sets_.begin()) {
        const LentSet& set = (--at)->second;
        if (set.range.source != range.source || end_of(set.range) <= range.first) break;
        found.push_back(set);
    }
    std::reverse(found.begin(), found.end());
    return found;
}

std::vector<LentSet> LentSets::in_the_way_of(const wire::Lease& lease) const {
    std::vector<LentSet> found = across(lease.range);
    const auto same = place_of_lease_.find(lease.lease);
    const bool is_among =
        std::any_of(found.begin(), found.end(), [&](const LentSet& set) { return set.lease == lease.lease; });
    if (same != place_of_lease_.end() && !is_among) found.push_back(sets_.at(same->second));
    return found;
}

void LentSets::add(const wire::Lease& lease) {
    ensure(across(lease.range).empty(), "a particle is lent once");
    sets_.emplace(place(lease.range), LentSet{lease.lease, lease.epoch, lease.range, lease.range.count});
    ensure(place_of_lease_.emplace(lease.lease, place(lease.range)).second, "a lease has a number of its own");
    left_ += lease.range.count;
}

std::optional<std::vector<wire::Claim>> LentSets::claims_of(std::span<const wire::Claim> covered) const {
    std::vector<wire::Claim> claims;
    for (const wire::Claim& part : covered) {
        std::uint64_t next = part.range.first;
        for (const LentSet& set : across(part.range)) {
            if (set.range.first > next) return std::nullopt;
            const std::uint64_t end = std::min(end_of(set.range), end_of(part.range));
            claims.emplace_back(set.lease, set.epoch, ParticleRange{part.range.source, next, end - next});
            next = end;
        }
        if (next != end_of(part.range)) return std::nullopt;
    }
    return claims;
}

void LentSets::claim(std::span<const wire::Claim> claims) {
    for (const wire::Claim& claim : claims) {
        const auto place = place_of_lease_.find(claim.lease);
        ensure(place != place_of_lease_.end(), "what is claimed is lent");
        LentSet& set = sets_.at(place->second);
        ensure(set.left >= claim.range.count, "a particle is claimed once");
        set.left -= claim.range.count;
        left_ -= claim.range.count;
        if (set.left > 0) continue;
        sets_.erase(place->second);
        place_of_lease_.erase(place);
    }
}

std::optional<LentSet> LentSets::remove(std::uint64_t lease) {
    const auto place = place_of_lease_.extract(lease);
    if (place.empty()) return std::nullopt;
    const LentSet set = sets_.extract(place.mapped()).mapped();
    left_ -= set.left;
    return set;
}

std::vector<LentSet> LentSets::all() const {
    std::vector<LentSet> all;
    for (const auto& [place, set] : sets_) all.push_back(set);
    return all;
}

std::uint64_t LentSets::mean_count() const {
    std::uint64_t sum = 0;
    for (const auto& [place, set] : sets_) sum += set.range.count;
    return std::max<std::uint64_t>(sum / sets_.size(), 1);
}

}  // namespace lumenfarm::relay
