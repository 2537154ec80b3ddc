#pragma once

#include "common/transport/launch.h"
#include "common/transport/path.h"
#include "common/transport/ray_log.h"
#include "common/transport/ray_query.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Many particles at once, from where they start to where they end or leave.
namespace lumenfarm {

/// The particles of a range in turn, made ready lanes at a time.
class Queue {
public:
    Queue(const Launcher& launcher, const PathRules& rules, const ParticleRange& range)
        : launcher_(launcher), rules_(rules), next_(range.first), end_(range.first + range.count) {}

    bool is_empty() const { return next_ == end_; }
    /// Gives how far along its ray the particle is. REQUIRES: !is_empty().
    double start_next(Flights& flights, std::size_t lane, EnergyBalance& balance) {
        const std::size_t in_block = next_ % lane_count;
        const std::uint64_t block = next_ - in_block;
        if (block != block_) launcher_.launch(static_cast<std::uint32_t>(block_ = block), launched_);
        rules_.start(flights, lane, static_cast<std::uint32_t>(next_++), launched_, in_block, balance);
        return 0;
    }

private:
    const Launcher& launcher_;
    const PathRules& rules_;
    std::uint64_t next_;
    std::uint64_t end_;
    LaunchLanes launched_;
    std::uint64_t block_ = ~std::uint64_t{0};  ///< the first particle of launched_
};

/// Flights in turn, from where they are.
class Arrivals {
public:
    /// `numbers`: of the query's triangles in the whole scene, ascending; null when these are all of them.
    Arrivals(std::span<const Flight> flights, const std::vector<std::uint32_t>* numbers)
        : flights_(flights), numbers_(numbers) {}

    bool is_empty() const { return next_ == flights_.size(); }
    double start_next(Flights& flights, std::size_t lane, EnergyBalance&) {
        Flight flight = flights_[next_++];
        if (numbers_) flight.from_triangle = number_here(flight.from_triangle);
        flights.set(lane, flight);
        return flight.travelled_m;
    }

private:
    /// A triangle that is not here will not be met here either.
    std::uint32_t number_here(std::uint32_t triangle) const {
        const auto at = std::lower_bound(numbers_->begin(), numbers_->end(), triangle);
        return at != numbers_->end() && *at == triangle ? static_cast<std::uint32_t>(at - numbers_->begin()) : none;
    }

    std::span<const Flight> flights_;
    const std::vector<std::uint32_t>* numbers_;
    std::size_t next_ = 0;
};

/// Where particles are followed: as long as they live.
struct WholeScene {
    /// The particle's ray, from a distance on, lies here; otherwise it was handed over, and its lane is free.
    static bool enter(const Flights&, std::size_t, double, EnergyBalance&) { return true; }
    static void find(const RayQuery& query, const Flights& flights, std::size_t active, MeetingLanes& meetings) {
        query.nearest(flights.rays, active, meetings);
    }
    /// What meets nothing here was handed over, and its lane is free.
    static bool leave(const Flights&, std::size_t, const Step&, EnergyBalance&) { return false; }
    static void move(std::size_t, std::size_t) {}
};

/// `Source`: as Queue. `Region`: as WholeScene. `log`, where given, receives every ray that is traced.
template <class Source, class Region>
inline void follow(const RayQuery& query, const PathRules& rules, Source& source, Region& region, TracedHits& hits,
                   RayLog* log) {
    Flights flights;
    Step step;
    const auto start = [&](std::size_t lane) {
        while (!source.is_empty())
            if (region.enter(flights, lane, source.start_next(flights, lane, hits.balance), hits.balance)) return true;
        return false;
    };
    std::size_t active = 0;
    while (active < lane_count && start(active)) ++active;
    while (active > 0) {
        if (log)
            for (std::size_t k = 0; k < active; ++k)
                log->push_back({flights.rays.at(k), flights.wavelength[k], flights.energy[k], hits.balance.absorbed,
                                hits.balance.cut_off});
        region.find(query, flights, active, step.meetings);
        rules.prepare(flights, step);
        std::size_t kept = 0;
        for (std::size_t k = 0; k < active; ++k) {
            if (!region.leave(flights, k, step, hits.balance) && rules.advance(flights, k, step, hits) &&
                region.enter(flights, k, 0, hits.balance)) {
                if (kept != k) {
                    flights.move(kept, k);
                    region.move(kept, k);
                }
            } else if (!start(kept)) {
                continue;
            }
            ++kept;
        }
        active = kept;
    }
}

}  // namespace lumenfarm
