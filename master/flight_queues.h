#pragma once

#include "master/job.h"
#include "proto/blocks.h"

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

/// Particles in flight that wait in the subspaces of a job, or are there with a worker whose result has not come. In
/// each subspace they are numbered from 0 as they were filed, and keep their numbers.
namespace lumenfarm {

class FlightQueues {
public:
    using Flights = std::vector<wire::FlightRecord>;
    /// Flights that were filed together. Shared, since a job's core and its log both have them.
    struct Filed {
        std::uint32_t subspace = 0;
        std::uint64_t first = 0;  ///< number of the first
        std::shared_ptr<const Flights> flights;
    };

    FlightQueues() = default;
    explicit FlightQueues(std::size_t subspaces) : queues_(subspaces) {}

    std::size_t subspaces() const { return queues_.size(); }
    /// How many were ever filed in the subspace.
    std::uint64_t filed(std::uint32_t subspace) const { return queues_[subspace].filed; }
    /// Numbers and keeps them.
    Filed file(std::uint32_t subspace, Flights flights);
    /// Keeps what others have numbered. What is missing before is gone already.
    void add(const Filed& filed);
    /// Keeps those of any numbers. REQUIRES: may_lend().
    void lend(const Filed& filed);
    /// Whether nothing is here that was filed together with a flight of the range.
    bool may_lend(std::uint32_t subspace, std::uint64_t first, std::uint64_t count) const;
    /// Numbers below are given out, to flights that are gone already.
    void skip_to(std::uint32_t subspace, std::uint64_t filed) { queues_[subspace].filed = filed; }
    /// Those have ended, or went on elsewhere. REQUIRES: they are here, each is removed once.
    void remove(std::uint32_t subspace, std::uint64_t first, std::uint64_t count);

    /// REQUIRES: filed and not removed.
    Flights at(std::uint32_t subspace, std::uint64_t first, std::uint64_t count) const;
    /// What they carry [ticks]. REQUIRES: as at().
    std::int64_t energy(std::uint32_t subspace, std::uint64_t first, std::uint64_t count) const;
    /// What all carry that are here [ticks].
    std::int64_t energy() const { return energy_; }
    /// How many are here.
    std::uint64_t count() const { return count_; }

private:
    struct Block {
        std::shared_ptr<const Flights> flights;
        std::uint64_t left = 0;  ///< not removed
    };
    struct Queue {
        std::uint64_t filed = 0;
        std::map<std::uint64_t, Block> blocks;  ///< by the number of their first flight
    };

    /// Calls visit(flight) for each.
    template <class Visit>
    void each(std::uint32_t subspace, std::uint64_t first, std::uint64_t count, Visit visit) const;

    void keep(const Filed& filed);

    std::vector<Queue> queues_;
    std::int64_t energy_ = 0;
    std::uint64_t count_ = 0;
};

/// What the claims' flights carry [ticks]. REQUIRES: they are here.
std::int64_t energy_of(const FlightQueues& flights, const PreparedJob& prepared, std::span<const wire::Claim> claims);

}  // namespace lumenfarm
