#pragma once

#include "common/transport/tracer.h"
#include "proto/messages.h"

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

/// The leases of one job that a master above has given to a relay, until results claim all of them or they go back.
namespace lumenfarm::relay {

struct LentSet {
    std::uint64_t lease = 0;
    std::uint32_t epoch = 0;
    ParticleRange range;
    std::uint64_t left = 0;  ///< of its particles that no result claims yet
};

class LentSets {
public:
    /// Leases that hold particles of this one, or have its number.
    std::vector<LentSet> in_the_way_of(const wire::Lease& lease) const;
    /// REQUIRES: nothing is in the way.
    void add(const wire::Lease& lease);

    /// What of the leases a result of these ranges claims; none when some of that is not lent.
    std::optional<std::vector<wire::Claim>> claims_of(std::span<const wire::Claim> covered) const;
    /// Leases that are claimed whole are let go. REQUIRES: claims_of() gave them; each particle is claimed once.
    void claim(std::span<const wire::Claim> claims);

    /// Lets go of a lease that goes back, if it is here.
    std::optional<LentSet> remove(std::uint64_t lease);
    /// Leases that hold particles of the range.
    std::vector<LentSet> across(const ParticleRange& range) const;
    std::vector<LentSet> all() const;
    bool empty() const { return sets_.empty(); }
    std::uint64_t left() const { return left_; }  ///< particles in all
    std::uint64_t mean_count() const;             ///< particles of a lease. REQUIRES: not empty

private:
    using Place = std::pair<std::uint32_t, std::uint64_t>;  ///< source and first particle
    static Place place(const ParticleRange& range) { return {range.source, range.first}; }

    std::map<Place, LentSet> sets_;
    std::map<std::uint64_t, Place> place_of_lease_;
    std::uint64_t left_ = 0;
};

}  // namespace lumenfarm::relay
