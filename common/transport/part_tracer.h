#pragma once

#include "common/octree/partition.h"
#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/support/result.h"
#include "common/transport/departure.h"
#include "common/transport/flight.h"
#include "common/transport/ray_query.h"
#include "common/transport/scene_part.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// The tracer of the object-space strategy: particles that are in one subspace, over the triangles that are there,
/// until they end or leave. All subspaces together give the hits of TracerScene to the bit (docs/subspaces.md).
namespace lumenfarm {

class PartTracer {
public:
    /// `palette` and `extent`: of the whole scene; REQUIRES: the palette outlives this. Errors and `isa` as
    /// TracerScene::make.
    static Result<std::unique_ptr<PartTracer>> make(ScenePart part, const Scene& palette, const SceneExtent& extent,
                                                    const std::string& isa = {});
    virtual ~PartTracer() = default;

    /// Appends to `hits`, numbered as in the whole scene, and to `departures`. What the flights carry in is absorbed,
    /// escapes, is cut off or departs, to the tick. The balance leaves out particles and what they emitted.
    /// REQUIRES: flights of this light that are in the subspace; the part holds its triangles.
    virtual void trace(const JobSpec& spec, std::uint32_t light, std::span<const Flight> flights,
                       const Partition& partition, std::uint32_t subspace, TracedHits& hits,
                       std::vector<Departure>& departures) const = 0;
};

}  // namespace lumenfarm
