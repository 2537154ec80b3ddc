#pragma once

#include "common/octree/partition.h"
#include "common/transport/flight.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <vector>

namespace lumenfarm {

/// A particle that goes on in a subspace.
struct Departure {
    std::uint32_t subspace = 0;
    Flight flight;
    bool operator==(const Departure&) const = default;
};

/// Files a particle where its ray goes on along this stretch, or books that it escapes. A ray that is nearly parallel
/// to the planes of cells may pass the next one where nothing of the scene can be.
inline void depart(Flight flight, const Stretch& stretch, std::vector<Departure>& departures, EnergyBalance& balance) {
    if (stretch.subspace == none || stretch.enters > farthest_m) {
        balance.escaped += flight.energy;
        return;
    }
    flight.travelled_m = stretch.enters;
    departures.push_back({stretch.subspace, flight});
}

}  // namespace lumenfarm
