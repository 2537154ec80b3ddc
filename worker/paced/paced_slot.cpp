#include "worker/paced/paced_slot.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lumenfarm::worker {

namespace {

std::uint64_t whole_slices(double particles) {
    return static_cast<std::uint64_t>(std::ceil(particles / limits::slice_particles)) * limits::slice_particles;
}

}  // namespace

void PacedSlot::begin(SetWork work) {
    ensure(!set_ && work.range.count > 0, "a slot has one set at a time");
    ensure(!open_job_ || open_job_->job == work.job->job, "a result is of one job");
    left_ = work.range;
    set_ = std::move(work);
}

void PacedSlot::go_on(double now_s) {
    ensure(set_ && tracing_ == 0, "a slot traces one set at a time");
    open_job_ = set_->job;
    tracing_ = std::min(left_.count, particles_until_full());
    since_s_ = now_s;
    stops_s_ = now_s + static_cast<double>(tracing_) / particles_per_s_;
}

void PacedSlot::interrupt(SlotAsk ask, double now_s) {
    ensure(tracing_ > 0, "a slot that waits is told");
    if (asked_ != SlotAsk::abandon) asked_ = ask;
    const std::uint64_t traced = whole_slices(std::max(1.0, (now_s - since_s_) * particles_per_s_));
    tracing_ = std::min(tracing_, traced);
    stops_s_ = since_s_ + static_cast<double>(tracing_) / particles_per_s_;
}

SlotReport PacedSlot::stop(SlotAsk ask) {
    if (asked_ != SlotAsk::nothing) ask = std::exchange(asked_, SlotAsk::nothing);
    if (const std::uint64_t traced = std::exchange(tracing_, 0); traced > 0) claim(traced);
    if (ask == SlotAsk::abandon) {
        set_.reset();
        open_job_.reset();
        open_ = {};
        open_hits_ = 0;
        return {};
    }
    SlotReport report;
    const bool finished = set_ && left_.count == 0;
    const bool records = open_job_ && open_job_->spec.packing == Packing::records;
    if (finished) set_.reset();
    const bool full = open_job_ && (particles_until_full() == limits::slice_particles);
    if (open_job_ && (ask == SlotAsk::close || full || (finished && records))) report.result = close();
    report.set_finished = finished;
    report.set_left = set_.has_value();
    report.open = open_job_ != nullptr;
    return report;
}

void PacedSlot::claim(std::uint64_t particles) {
    open_.add_claim({set_->lease, set_->epoch, {left_.source, left_.first, particles}});
    open_.trace_s += static_cast<double>(particles) / particles_per_s_;
    open_.cpu_s += static_cast<double>(particles) / particles_per_s_;
    open_hits_ += static_cast<double>(particles) * results_->hits_per_particle(left_.source);
    left_.first += particles;
    left_.count -= particles;
}

/// A slice at least.
std::uint64_t PacedSlot::particles_until_full() const {
    if (open_.claims.size() >= limits::claims_per_result_max) return limits::slice_particles;
    const double hits_max = open_job_->spec.packing == Packing::records
                                ? static_cast<double>(limits::result_close_bytes / limits::hit_record_bytes)
                                : static_cast<double>(limits::hits_per_map_max / 2);
    const double left = (hits_max - open_hits_) / std::max(results_->hits_per_particle(left_.source), 1e-3);
    return whole_slices(std::max(1.0, left));
}

Parcel PacedSlot::close() {
    open_.job = open_job_->job;
    open_.hits_per_message = open_job_->spec.hits_per_message;
    if (open_job_->spec.packing == Packing::maps) {
        results_->add_sums(open_.claims, open_);
    } else {
        for (const wire::Claim& claim : open_.claims) results_->add_hits(claim.range, open_);
    }
    open_job_.reset();
    open_hits_ = 0;
    return std::exchange(open_, {});
}

}  // namespace lumenfarm::worker
