#pragma once

#include "common/octree/subspaces.h"
#include "common/scene/scene.h"
#include "common/transport/clearance.h"
#include "common/transport/departure.h"
#include "common/transport/emission.h"
#include "common/transport/ray_query.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <vector>

namespace lumenfarm {

/// Lets particles leave their lights and says in which subspace each of them begins, for the object-space strategy.
/// They are those of TracerScene::trace to the bit.
class Emitter {
public:
    /// REQUIRES: the arguments outlive this.
    Emitter(const Scene& scene, const Emission& emission, const Subspaces& subspaces, std::uint64_t seed);

    /// Appends the particles of the range, and books what they emit, and what misses everything.
    void emit(const ParticleRange& range, std::vector<Departure>& departures, EnergyBalance& balance) const;

private:
    const Scene& scene_;
    const Emission& emission_;
    const Subspaces& subspaces_;
    std::uint64_t seed_;
    SceneExtent extent_;
    ClearanceMap clear_nowhere_;
    std::vector<std::vector<TriangleRecord>> triangles_;  ///< of each light
};

}  // namespace lumenfarm
