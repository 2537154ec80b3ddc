#include "worker/worker_core.h"

#include <algorithm>
#include <utility>

/// The worker's core: subspaces whose triangles are brought in and given up (docs/subspaces.md).
namespace lumenfarm::worker {

namespace {

/// What a job takes beside its parts: its plan, and the sums of each thread.
std::uint64_t bytes_beside_parts(const JobContext& job, std::uint64_t plan_bytes, std::uint64_t threads) {
    const std::uint64_t texels = job.layout ? job.layout->texel_count() : 0;
    return limits::plan_bytes_factor * plan_bytes + threads * texels * sizeof(TexelSums);
}

}  // namespace

bool WorkerCore::has_subspaces(JobId job) const { return shelf_.has(job); }

/// The subspace of a set, unless it is of a light.
std::optional<PartKey> WorkerCore::part_of(const wire::Lease& lease) const {
    const auto job = jobs_.find(lease.job);
    if (job == jobs_.end() || !job->second.context || !job->second.context->plan) return std::nullopt;
    const std::uint32_t lights = job->second.context->lights();
    if (lease.range.source < lights) return std::nullopt;
    return PartKey{lease.job, lease.range.source - lights};
}

/// What is needed to trace a set, or serves it where it is of a light.
std::optional<PartKey> WorkerCore::piece_for(const wire::Lease& lease) const {
    const PartKey whole{lease.job, none};
    return shelf_.holds(whole) ? whole : part_of(lease);
}

/// Whether a set can be traced with what is at hand. Sets of a light wait until the memory is filled: what they emit
/// into a subspace that is not at hand goes back to the master.
bool WorkerCore::is_at_hand(const wire::Lease& lease) const {
    if (!has_subspaces(lease.job)) return true;
    if (making_room_) return false;
    const auto part = part_of(lease);
    return part ? shelf_.holds(*part) : !bringing_ && !shelf_.next({});
}

/// Whether the set is one that the job can have.
bool WorkerCore::is_possible(const wire::Lease& lease) const {
    const auto job = jobs_.find(lease.job);
    if (job == jobs_.end() || !job->second.context) return true;
    const std::uint32_t lights = job->second.context->lights();
    const std::size_t subspaces = job->second.context->plan ? job->second.context->plan->plan.parts.size() : 0;
    if (lease.range.source < lights) return lease.flights.empty();
    return lease.range.source - lights < subspaces && lease.flights.size() == lease.range.count &&
           std::all_of(lease.flights.begin(), lease.flights.end(), [&](const wire::FlightRecord& flight) {
               return flight.light < lights &&
                      (flight.from_triangle == none ||
                       flight.from_triangle < job->second.context->plan->plan.first_triangle.back());
           });
}

Result<void> WorkerCore::open_parts(const Job& job) {
    if (!job.context->plan) return {};
    return shelf_.open(job.context, bytes_beside_parts(*job.context, job.info.scene_bytes, slots_.size()));
}

/// One after the other. What has to go for one goes when no slot is at work on it.
void WorkerCore::bring_next() {
    if (bringing_ || drain_by_s_) return;
    std::vector<PartKey> needed;
    for (const wire::Lease& lease : queue_)
        if (const auto piece = piece_for(lease); piece && !draining(lease.job)) needed.push_back(*piece);
    const auto next = shelf_.next(needed);
    making_room_ = next && !next->given_up.empty();
    if (!next) return;
    const bool busy = std::any_of(slots_.begin(), slots_.end(), [&](const Slot& slot) {
        return (slot.running || slot.lease) && has_subspaces(slot.job);
    });
    if (making_room_ && busy) return;
    for (const PartKey& key : next->given_up) next->key == whole_of(key) ? shelf_.give_up(key) : give_up(key);
    making_room_ = false;
    bringing_ = Bringing{next->key, next->file};
    if (!next->given_up.empty()) tell_parts();
    effects_.push_back(LoadScene{next->file.file});
}

/// Many a second may be: the log names the first of a job.
void WorkerCore::give_up(const PartKey& key) {
    Job& job = jobs_.at(key.job);
    const std::size_t held = shelf_.held(key.job).size();
    shelf_.give_up(key);
    // its sets of lights may be larger than what they would send on from now on
    if (key.is_whole()) return_queued(key.job);
    if (std::exchange(job.gives_parts_up, true)) return counts_.discards.count(Discard::part_given_up, 1);
    count(Discard::part_given_up, 1,
          "job " + std::to_string(key.job) + ": the memory held " + std::to_string(held) + " of its " +
              std::to_string(job.context->plan->plan.parts.size()) + " subspaces; from now on they take turns");
}

/// What can't be had whole may still be had in parts.
void WorkerCore::fail_bringing(wire::ReturnReason reason) {
    const PartKey key = bringing_->key;
    bringing_.reset();
    key.is_whole() ? shelf_.fail_whole(key.job) : fail_job(key.job, reason);
}

void WorkerCore::prepare_part_of(const Digest& file, const std::shared_ptr<const std::vector<std::byte>>& bytes) {
    if (!bringing_ || bringing_->file.file != file || std::exchange(bringing_->preparing, true)) return;
    bringing_->missing = false;
    effects_.push_back(PreparePart{bringing_->key, file, jobs_.at(bringing_->key.job).context, bytes});
}

Effects WorkerCore::on_part_prepared(const PartKey& key, const Digest& file, Result<Piece> prepared, double now_s) {
    // what was made for an earlier job of that number is of no use
    if (bringing_ && bringing_->key == key && bringing_->file.file == file) {
        if (prepared) {
            bringing_.reset();
            shelf_.put(key, std::move(*prepared));
            ++parts_brought_;
            tell_parts();
        } else {
            fail_bringing(wire::ReturnReason::tracer_failed);
        }
    }
    return settle_and_take(now_s);
}

/// They share the memory.
void WorkerCore::tell_parts() {
    for (const JobId job : shelf_.jobs()) tell_parts(job);
}

void WorkerCore::tell_parts(JobId job) {
    const auto known = jobs_.find(job);
    if (!welcome_ || known == jobs_.end() || !known->second.confirmed || !has_subspaces(job)) return;
    std::vector<std::uint32_t> held = shelf_.held(job);
    const bool all = held.size() == known->second.context->plan->plan.parts.size();
    send(wire::PartsHeld(job, std::move(held), shelf_.room_triangles(), all));
}

void WorkerCore::close_parts(JobId job) {
    shelf_.close(job);
    if (bringing_ && bringing_->key.job == job) bringing_.reset();
}

}  // namespace lumenfarm::worker
