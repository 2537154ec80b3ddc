#pragma once

#include "common/octree/partition.h"
#include "common/scene/job_spec.h"
#include "common/transport/departure.h"
#include "common/transport/part_tracer.h"
#include "common/transport/tracer.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace lumenfarm {

/// The subspaces whose triangles are at hand. Particles are followed through all of them; whatever is at hand, the
/// hits of all workers together are the same.
class Territory {
public:
    /// By subspace; null where the triangles are not at hand. REQUIRES: one for each, `partition` outlives this.
    Territory(const Partition& partition, std::vector<std::shared_ptr<const PartTracer>> parts)
        : partition_(&partition), parts_(std::move(parts)) {}

    bool holds(std::uint32_t subspace) const { return parts_[subspace] != nullptr; }

    /// Follows particles of one light until they end, and appends to `departures` those that go on elsewhere.
    /// Otherwise as PartTracer::trace.
    void trace(const JobSpec& spec, std::uint32_t light, const std::vector<Departure>& arrivals, TracedHits& hits,
               std::vector<Departure>& departures) const;

private:
    const Partition* partition_;
    std::vector<std::shared_ptr<const PartTracer>> parts_;
};

}  // namespace lumenfarm
