#pragma once

#include "worker/paced/paced_results.h"
#include "worker/trace_slot.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace lumenfarm::worker {

/// What TraceSlot is, but that time passes where it would trace. Times are seconds of one clock of the caller's.
class PacedSlot {
public:
    /// `particles_per_s` > 0: of the tracing thread that this stands for.
    PacedSlot(std::shared_ptr<const PacedResults> results, double particles_per_s)
        : results_(std::move(results)), particles_per_s_(particles_per_s) {}

    /// REQUIRES: no set is left, and an open result is of the same job.
    void begin(SetWork work);
    /// Traces from `now_s` on. REQUIRES: a set is left, and it is not tracing.
    void go_on(double now_s);
    /// Stops after the slice at hand, to obey. REQUIRES: it is tracing.
    void interrupt(SlotAsk ask, double now_s);
    /// When it stops, if it is tracing: then stop() has its report.
    double stops_s() const { return stops_s_; }
    /// What it has done since go_on(); or, of a slot that waits, what it is told.
    SlotReport stop(SlotAsk ask = SlotAsk::nothing);

private:
    void claim(std::uint64_t particles);
    std::uint64_t particles_until_full() const;
    Parcel close();

    std::shared_ptr<const PacedResults> results_;
    double particles_per_s_;
    std::optional<SetWork> set_;
    ParticleRange left_;
    std::uint64_t tracing_ = 0;  ///< particles that are claimed when it stops; 0: it waits
    double since_s_ = 0, stops_s_ = 0;
    SlotAsk asked_ = SlotAsk::nothing;
    std::shared_ptr<const JobContext> open_job_;  ///< of the open result; null: none
    Parcel open_;                                 ///< its claims and times
    double open_hits_ = 0;                        ///< about so many
};

}  // namespace lumenfarm::worker
