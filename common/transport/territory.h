#pragma once

#include "common/octree/partition.h"
#include "common/scene/job_spec.h"
#include "common/support/limits.h"
#include "common/transport/departure.h"
#include "common/transport/emitter.h"
#include "common/transport/part_tracer.h"
#include "common/transport/tracer.h"
#include "common/transport/work_meter.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace lumenfarm {

/// What became of particles in a territory.
struct TracedFlights {
    TracedHits hits;
    std::vector<Departure> departures;  ///< that go on elsewhere

    void clear() {
        hits.clear();
        departures.clear();
    }
};

/// The subspaces whose triangles are at hand. Particles are followed through all of them; whatever is at hand, the
/// hits of all workers together are the same.
class Territory {
public:
    /// All of them, over one hierarchy: particles need not be asked for in each subspace that their rays pass.
    explicit Territory(std::shared_ptr<const TracerScene> whole) : whole_(std::move(whole)) {}
    /// By subspace; null where the triangles are not at hand. REQUIRES: one for each, `partition` outlives this.
    Territory(const Partition& partition, std::vector<std::shared_ptr<const PartTracer>> parts)
        : partition_(&partition), parts_(std::move(parts)) {}

    bool holds(std::uint32_t subspace) const { return whole_ || parts_[subspace]; }

    bool is_whole() const { return whole_ != nullptr; }

    /// Lets particles leave their light, and follows them as trace() does. `emitter`: of the same scene.
    void emit(const JobSpec& spec, const ParticleRange& range, const Emitter& emitter, std::uint64_t hits_max,
              TracedFlights& traced, WorkMeter* meter) const;
    /// Follows particles of one light until they end or leave, and appends what became of them. Otherwise as
    /// PartTracer::trace. Of a part: once they have left `hits_max` hits they all leave, some
    /// limits::flights_at_once * limits::bounces_max hits later at most; `meter`, if there is one, learns what each
    /// subspace took.
    void trace(const JobSpec& spec, std::uint32_t light, const std::vector<Departure>& arrivals, std::uint64_t hits_max,
               TracedFlights& traced, WorkMeter* meter) const;

private:
    void trace_parts(const JobSpec& spec, std::uint32_t light, const std::vector<Departure>& arrivals,
                     std::uint64_t hits_max, TracedFlights& traced, WorkMeter* meter) const;

    std::shared_ptr<const TracerScene> whole_;
    const Partition* partition_ = nullptr;
    std::vector<std::shared_ptr<const PartTracer>> parts_;
};

}  // namespace lumenfarm
