#include "worker/trace_slot.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <map>
#include <utility>

namespace lumenfarm {

namespace {

/// Looks at the clock cost up to a twelfth of the tracing time where subspaces are many and small: what a part of the
/// slices took stands for all.
constexpr std::uint64_t slices_a_measured_one = 5;

}  // namespace

void TraceSlot::begin(SetWork work) {
    ensure(!set_ && work.range.count > 0, "a slot has one set at a time");
    ensure(!open_job_ || open_job_->job == work.job->job, "a result is of one job");
    left_ = work.range;
    set_ = std::move(work);
}

std::optional<SlotReport> TraceSlot::advance(SlotAsk ask) {
    if (ask == SlotAsk::abandon) {
        if (open_job_ && sums_) sums_->clear();
        set_.reset();
        open_job_.reset();
        open_ = {};
        return SlotReport{};
    }
    if (ask == SlotAsk::close) return report(true, false);
    ensure(set_.has_value(), "a slot traces the set that it was given");
    trace_slice();
    const bool finished = left_.count == 0;
    const bool records = set_->job->spec.packing == Packing::records;
    if (finished) set_.reset();
    if (!finished && !full()) return std::nullopt;
    return report(full() || (finished && records), finished);
}

SlotReport TraceSlot::report(bool close_it, bool finished) {
    SlotReport report;
    if (close_it && open_job_) report.result = close();
    report.set_finished = finished;
    report.set_left = set_.has_value();
    report.open = open_job_ != nullptr;
    return report;
}

void TraceSlot::trace_slice() {
    const JobContext& job = *set_->job;
    const ParticleRange slice{left_.source, left_.first, std::min(left_.count, slice_particles())};
    left_.first += slice.count;
    left_.count -= slice.count;
    open_job_ = set_->job;
    const std::uint64_t hits_before = open_.balance.hits;
    const double wall_s = clocks_.wall_s(), cpu_s = clocks_.cpu_s();
    traced_.clear();
    if (job.plan) {
        trace_in_territory(slice, slices_++ % slices_a_measured_one == 0 ? &meter_ : nullptr);
        for (const SubspaceWork& each : meter_.take()) open_.add_work(each);
    } else {
        job.scene->tracer->trace(job.spec, slice, traced_.hits);
        keep(slice.source);
    }
    open_.trace_s += clocks_.wall_s() - wall_s;
    open_.cpu_s += clocks_.cpu_s() - cpu_s;
    open_.add_claim({set_->lease, set_->epoch, slice});
    hits_per_particle_ = static_cast<double>(open_.balance.hits - hits_before) / static_cast<double>(slice.count);
}

/// In parts as many as are best traced at a time, but so few that their hits are not many more than those of a result.
std::uint64_t TraceSlot::slice_particles() const {
    constexpr double hits_wanted = limits::result_close_bytes / (limits::hit_record_bytes + limits::hit_energy_bytes);
    if (!set_->territory || set_->territory->is_whole()) return limits::slice_particles;
    return static_cast<std::uint64_t>(std::clamp(hits_wanted / std::max(hits_per_particle_, 1.0),
                                                 double{limits::slice_particles},
                                                 double{limits::slice_particles_in_parts}));
}

/// Particles that leave their light, or go on in a subspace, light by light.
void TraceSlot::trace_in_territory(const ParticleRange& slice, WorkMeter* meter) {
    const JobContext& job = *set_->job;
    std::uint64_t hits_left = hits_per_slice_max_;
    const auto keep_all = [&](std::uint32_t light) {
        hits_left -= std::min(hits_left, traced_.hits.balance.hits);
        keep(light);
        keep_departures(light);
        traced_.clear();
    };
    if (slice.source < job.lights()) {
        set_->territory->emit(job.spec, slice, job.plan->emitter, hits_left, traced_, meter);
        return keep_all(slice.source);
    }
    const std::uint32_t subspace = slice.source - job.lights();
    const auto begin = set_->flights.begin() + static_cast<std::ptrdiff_t>(slice.first - set_->range.first);
    std::map<std::uint32_t, std::vector<Departure>> by_light;
    for (auto flight = begin; flight != begin + static_cast<std::ptrdiff_t>(slice.count); ++flight)
        by_light[flight->light].push_back({subspace, wire::unpack_flight(*flight)});
    for (const auto& [light, arrivals] : by_light) {
        set_->territory->trace(job.spec, light, arrivals, hits_left, traced_, meter);
        keep_all(light);
    }
}

void TraceSlot::keep(std::uint32_t light) {
    const JobSpec& spec = set_->job->spec;
    open_.balance += traced_.hits.balance;
    if (spec.packing == Packing::records) return open_.add_hits(light, traced_.hits.records, traced_.hits.energies);
    keep_sums(light);
    if (spec.keep_hits > 0) keep_candidates(light);
}

void TraceSlot::keep_departures(std::uint32_t light) {
    for (const Departure& departure : traced_.departures)
        open_.flights[departure.subspace].push_back(wire::pack_flight(departure.flight, light));
}

void TraceSlot::keep_sums(std::uint32_t light) {
    if (map_job_ != set_->job) {
        map_job_ = set_->job;
        sums_.emplace(map_job_->empty_map());
    }
    sums_->add(map_job_->emission(), light, traced_.hits.records, traced_.hits.energies);
}

void TraceSlot::keep_candidates(std::uint32_t light) {
    const auto& energy_of_bin = set_->job->emission().lights[light].energy;
    for (std::size_t i = 0; i < traced_.hits.records.size(); ++i) {
        const HitRecord& record = traced_.hits.records[i];
        const std::uint32_t energy =
            traced_.hits.energies.empty() ? energy_of_bin[record.wavelength] : traced_.hits.energies[i];
        const KeptHit hit{record, light, energy};
        if (keep_priority(hit) <= set_->keep_threshold) open_.kept.push_back(hit);
    }
}

bool TraceSlot::full() const {
    return open_.bytes() >= limits::result_close_bytes || open_.balance.hits >= limits::hits_per_map_max / 2 ||
           open_.claims.size() >= limits::claims_per_result_max;
}

Parcel TraceSlot::close() {
    open_.job = open_job_->job;
    open_.hits_per_message = open_job_->spec.hits_per_message;
    if (open_job_->spec.packing == Packing::maps) move_sums(*sums_, open_);
    open_job_.reset();
    return std::exchange(open_, {});
}

}  // namespace lumenfarm
