#include "worker/part_shelf.h"

#include "common/support/limits.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <utility>

namespace lumenfarm::worker {

namespace {

std::string mebibytes(std::uint64_t bytes) { return std::to_string((bytes + (1u << 20) - 1) >> 20) + " MiB"; }

}  // namespace

std::uint64_t PartShelf::bytes_of(const PartFile& part) {
    return limits::part_bytes + limits::part_bytes_per_triangle * part.triangles;
}

std::string PartKey::text() const {
    return (is_whole() ? "the scene" : "subspace " + std::to_string(subspace)) + " of job " + std::to_string(job);
}

const PartFile& PartShelf::file(const PartKey& key) const {
    const ScenePlan& plan = jobs_.at(key.job).context->plan->plan;
    return key.is_whole() ? plan.whole : plan.parts[key.subspace];
}

std::uint64_t PartShelf::bytes_of(JobId id, const Job& job) const {
    std::uint64_t bytes = 0;
    for (const auto& [subspace, part] : job.parts) bytes += bytes_of(file({id, subspace}));
    return bytes;
}

/// The memory that others leave holds all of the scene. One that is here in parts changes to it only when it is alone:
/// two might drive each other out again and again.
bool PartShelf::takes_whole(JobId id, const Job& job) const {
    if (parts_only_ || job.whole_failed || job.parts.contains(none)) return false;
    if (!job.parts.empty() && jobs_.size() > 1) return false;
    return !bytes_max_ || used_bytes_ + bytes_of(file({id, none})) <= *bytes_max_ + bytes_of(id, job);
}

std::vector<JobId> PartShelf::jobs() const {
    std::vector<JobId> ids;
    for (const auto& [id, job] : jobs_) ids.push_back(id);
    return ids;
}

std::uint64_t PartShelf::room_triangles() const {
    if (!bytes_max_) return std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t used = used_bytes_ + limits::part_bytes;
    return used >= *bytes_max_ ? 0 : (*bytes_max_ - used) / limits::part_bytes_per_triangle;
}

Result<void> PartShelf::open(std::shared_ptr<const JobContext> context, std::uint64_t bytes) {
    std::uint64_t largest = 0;
    for (const PartFile& part : context->plan->plan.parts) largest = std::max(largest, bytes_of(part));
    if (bytes_max_ && bytes + largest > *bytes_max_)
        return bad_input("the memory limit leaves " + mebibytes(*bytes_max_) + " for triangles; the largest of " +
                         std::to_string(context->plan->plan.parts.size()) + " subspaces needs " +
                         mebibytes(bytes + largest) + ": raise the limit, or cut the scene into more subspaces");
    close(context->job);
    Job& job = jobs_[context->job];
    job.context = std::move(context);
    job.bytes = bytes;
    used_bytes_ += bytes;
    renew(job);
    return {};
}

void PartShelf::close(JobId id) {
    const auto job = jobs_.find(id);
    if (job == jobs_.end()) return;
    used_bytes_ -= job->second.bytes + bytes_of(id, job->second);
    jobs_.erase(job);
}

std::optional<PartShelf::Next> PartShelf::next(std::span<const PartKey> needed) const {
    if (auto next = next_whole()) return next;
    if (auto next = next_needed(needed)) return next;
    return next_with_room();
}

std::optional<PartShelf::Next> PartShelf::next_whole() const {
    for (const auto& [id, job] : jobs_) {
        if (!takes_whole(id, job)) continue;
        Next next{{id, none}, file({id, none}), {}};
        for (const auto& [subspace, part] : job.parts) next.given_up.push_back({id, subspace});
        return next;
    }
    return std::nullopt;
}

std::optional<PartShelf::Next> PartShelf::next_needed(std::span<const PartKey> needed) const {
    const auto missing =
        std::find_if(needed.begin(), needed.end(), [&](const PartKey& key) { return has(key.job) && !holds(key); });
    if (missing == needed.end()) return std::nullopt;
    Next next{*missing, file(*missing), {}};
    if (!bytes_max_) return next;
    // what earlier sets need stays until they have begun
    const std::set<PartKey> is_needed(needed.begin(), missing);
    std::vector<std::pair<std::uint64_t, PartKey>> by_use;
    bool others_stay = false;
    for (const auto& [id, job] : jobs_)
        for (const auto& [subspace, part] : job.parts) {
            const PartKey held{id, subspace};
            if (is_needed.contains(held))
                others_stay = true;
            else
                by_use.emplace_back(part.used, held);
        }
    std::sort(by_use.begin(), by_use.end());
    std::uint64_t bytes = used_bytes_ + bytes_of(next.file);
    for (const auto& [used, held] : by_use) {
        if (bytes <= *bytes_max_) break;
        bytes -= bytes_of(file(held));
        next.given_up.push_back(held);
    }
    if (bytes > *bytes_max_ && others_stay) return std::nullopt;
    return next;
}

std::optional<PartShelf::Next> PartShelf::next_with_room() const {
    for (const auto& [id, job] : jobs_) {
        if (job.parts.contains(none)) continue;
        const auto& parts = job.context->plan->plan.parts;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const auto subspace = static_cast<std::uint32_t>((first_ + i) % parts.size());
            if (!job.parts.contains(subspace) && fits(bytes_of(parts[subspace])))
                return Next{{id, subspace}, parts[subspace], {}};
        }
    }
    return std::nullopt;
}

void PartShelf::put(const PartKey& key, Piece piece) {
    Job& job = jobs_.at(key.job);
    if (job.parts.insert_or_assign(key.subspace, Part{std::move(piece), ++uses_}).second)
        used_bytes_ += bytes_of(file(key));
    renew(job);
}

void PartShelf::give_up(const PartKey& key) {
    Job& job = jobs_.at(key.job);
    if (job.parts.erase(key.subspace) > 0) used_bytes_ -= bytes_of(file(key));
    renew(job);
}

void PartShelf::fail_whole(JobId id) {
    if (const auto job = jobs_.find(id); job != jobs_.end()) job->second.whole_failed = true;
}

void PartShelf::use(const PartKey& key) {
    const auto job = jobs_.find(key.job);
    if (job == jobs_.end()) return;
    for (const std::uint32_t subspace : {key.subspace, none})
        if (const auto part = job->second.parts.find(subspace); part != job->second.parts.end())
            part->second.used = ++uses_;
}

bool PartShelf::holds(const PartKey& key) const {
    const auto job = jobs_.find(key.job);
    return job != jobs_.end() && (job->second.parts.contains(key.subspace) || job->second.parts.contains(none));
}

std::vector<std::uint32_t> PartShelf::held(JobId id) const {
    const auto job = jobs_.find(id);
    if (job == jobs_.end()) return {};
    if (job->second.parts.contains(none)) {
        std::vector<std::uint32_t> all(job->second.context->plan->plan.parts.size());
        std::iota(all.begin(), all.end(), 0u);
        return all;
    }
    std::vector<std::uint32_t> held;
    for (const auto& [subspace, part] : job->second.parts) held.push_back(subspace);
    return held;
}

std::shared_ptr<const Territory> PartShelf::territory(JobId job) const { return jobs_.at(job).territory; }

void PartShelf::renew(Job& job) {
    if (const auto whole = job.parts.find(none); whole != job.parts.end()) {
        job.territory = std::make_shared<const Territory>(whole->second.piece.whole);
        return;
    }
    const ScenePlan& plan = job.context->plan->plan;
    std::vector<std::shared_ptr<const PartTracer>> parts(plan.parts.size());
    for (const auto& [subspace, part] : job.parts) parts[subspace] = part.piece.part;
    job.territory = std::make_shared<const Territory>(plan.partition, std::move(parts));
}

}  // namespace lumenfarm::worker
