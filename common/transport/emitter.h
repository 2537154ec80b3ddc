#pragma once

#include "common/octree/partition.h"
#include "common/transport/clearance.h"
#include "common/transport/departure.h"
#include "common/transport/emission.h"
#include "common/transport/ray_query.h"
#include "common/transport/scene_part.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <vector>

namespace lumenfarm {

/// Lets particles leave their lights and says in which subspace each of them begins, for the object-space strategy.
/// They are those of TracerScene::trace to the bit.
class Emitter {
public:
    /// `palette`: of the scene; `extent`: of the whole. REQUIRES: the references outlive this.
    Emitter(const ScenePart& palette, const Emission& emission, const Partition& partition, const SceneExtent& extent);

    /// Appends the particles of the range, and books what they emit.
    void emit(std::uint64_t seed, const ParticleRange& range, std::vector<Departure>& departures,
              EnergyBalance& balance) const;

private:
    const ScenePart& palette_;
    const Emission& emission_;
    const Partition& partition_;
    SceneExtent extent_;
    ClearanceMap clear_nowhere_;
    std::vector<std::vector<TriangleRecord>> triangles_;  ///< of each light
};

}  // namespace lumenfarm
