#pragma once

#include "common/octree/subspaces.h"
#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/support/result.h"
#include "common/transport/departure.h"
#include "common/transport/flight.h"
#include "common/transport/ray_query.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// The tracer of the object-space strategy: particles that are in one subspace, over the triangles that are there,
/// until they end or leave. All subspaces together give the hits of TracerScene to the bit (docs/subspaces.md).
namespace lumenfarm {

/// Some triangles of a scene, with all its materials and spectra, and all its surfaces, of which some are empty.
struct ScenePart {
    Scene scene;                         ///< its lights and cameras are left out
    std::vector<std::uint32_t> numbers;  ///< of its triangles in the whole scene, ascending
    SceneExtent extent;                  ///< of the whole scene
};

/// The part with these triangles. REQUIRES: ascending, of the scene.
ScenePart part_of(const Scene& scene, std::span<const std::uint32_t> triangles);

/// How near to a subspace a triangle may pass that has to be in its part.
double part_margin_m(const SceneExtent& extent);

class PartTracer {
public:
    /// REQUIRES: `part` outlives this; it may have no triangles. Errors and `isa` as TracerScene::make.
    static Result<std::unique_ptr<PartTracer>> make(const ScenePart& part, const std::string& isa = {});
    virtual ~PartTracer() = default;

    /// Appends to `hits`, numbered as in the whole scene, and to `departures`. What the flights carry in is absorbed,
    /// escapes, is cut off or departs, to the tick. The balance leaves out particles and what they emitted.
    /// REQUIRES: flights of this light that are in the subspace; the part holds its triangles.
    virtual void trace(const JobSpec& spec, std::uint32_t light, std::span<const Flight> flights,
                       const Subspaces& subspaces, std::uint32_t subspace, TracedHits& hits,
                       std::vector<Departure>& departures) const = 0;
};

}  // namespace lumenfarm
