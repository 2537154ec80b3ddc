#pragma once

#include "common/solution/solution.h"
#include "common/transport/territory.h"
#include "worker/parcel.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

/// One tracing thread's work, without the thread: sets go in, closed results come out.
namespace lumenfarm {

/// A leased set.
struct SetWork {
    std::shared_ptr<const JobContext> job;
    std::uint64_t lease = 0;
    std::uint32_t epoch = 0;
    ParticleRange range;
    std::uint64_t keep_threshold = 0;
    std::vector<wire::FlightRecord> flights = {};          ///< of a subspace's range
    std::shared_ptr<const Territory> territory = nullptr;  ///< strategy subspaces: what is at hand
};

/// What the core asks of a slot between two slices.
enum class SlotAsk : std::uint8_t {
    nothing,
    close,    ///< hand the open result over
    abandon,  ///< throw the set and the open result away
};

/// Why a slot stopped; it then waits for the core's next word.
struct SlotReport {
    std::optional<Parcel> result;
    bool set_finished = false;
    bool set_left = false;  ///< particles of the set are still to be traced
    bool open = false;      ///< a result is open and will be closed later (packing maps)
};

/// Seconds of wall time and of this thread's CPU time, for the statistics of a result.
struct SlotClocks {
    std::function<double()> wall_s;
    std::function<double()> cpu_s;
};

class TraceSlot {
public:
    /// `hits_per_slice_max`: as limits::hits_per_slice_max.
    explicit TraceSlot(SlotClocks clocks, std::uint64_t hits_per_slice_max = limits::hits_per_slice_max)
        : clocks_(std::move(clocks)), meter_(clocks_.cpu_s), hits_per_slice_max_(hits_per_slice_max) {}

    /// REQUIRES: no set is left, and an open result is of the same job.
    void begin(SetWork work);

    /// Obeys `ask`, or traces the next slice. Returns a report when the core has to know:
    /// asked, the set finished, or the result reached its limits. Packing records closes a result at the end of a set
    /// at the latest; packing maps goes on adding to it until it is asked for. REQUIRES: a set is left, or `ask`.
    std::optional<SlotReport> advance(SlotAsk ask);

private:
    void trace_slice();
    std::uint64_t slice_particles() const;
    void trace_in_territory(const ParticleRange& slice, WorkMeter* meter);
    void keep(std::uint32_t light);
    void keep_sums(std::uint32_t light);
    void keep_candidates(std::uint32_t light);
    void keep_departures(std::uint32_t light);
    bool full() const;
    SlotReport report(bool close, bool finished);
    Parcel close();

    SlotClocks clocks_;
    WorkMeter meter_;
    std::uint64_t hits_per_slice_max_;
    std::uint64_t slices_ = 0;
    double hits_per_particle_ = limits::bounces_max;  ///< of the last slice
    std::optional<SetWork> set_;
    ParticleRange left_;
    std::shared_ptr<const JobContext> open_job_;  ///< of the open result; null: none
    Parcel open_;
    std::shared_ptr<const JobContext> map_job_;  ///< that sums_ is of
    std::optional<LightMap> sums_;
    TracedFlights traced_;
};

}  // namespace lumenfarm
