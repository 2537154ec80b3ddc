#pragma once

#include "common/transport/territory.h"
#include "worker/job_context.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

/// Which subspaces of which jobs this worker has the triangles of, and which come next, within its memory
/// (docs/subspaces.md). Knows no file and no thread.
namespace lumenfarm::worker {

struct PartKey {
    JobId job = 0;
    std::uint32_t subspace = 0;
    auto operator<=>(const PartKey&) const = default;
};

class PartShelf {
public:
    /// `bytes_max`: for the parts and plans of all jobs together; none: no limit. `first`: which part a job begins
    /// with, so that workers that can't have all have different ones.
    explicit PartShelf(std::optional<std::uint64_t> bytes_max, std::uint64_t first = 0)
        : bytes_max_(bytes_max), first_(first) {}

    /// A job of the object-space strategy, which takes `bytes` beside its parts. Errors: bad_input (the largest part
    /// does not fit the memory).
    Result<void> open(std::shared_ptr<const JobContext> job, std::uint64_t bytes);
    void close(JobId job);
    bool has(JobId job) const { return jobs_.contains(job); }

    struct Next {
        PartKey key;
        PartFile file;
        std::vector<PartKey> given_up;  ///< that have to go before
    };
    /// What to bring in next: the first of `needed` that is missing, or what there is room for. Others go for one that
    /// is needed, the one that was used longest ago first, but not what is needed before it. Keys of jobs that are not
    /// open are ignored.
    std::optional<Next> next(std::span<const PartKey> needed) const;
    void put(const PartKey& key, std::shared_ptr<const PartTracer> part);
    void give_up(const PartKey& key);
    /// Particles of it are going to be traced.
    void use(const PartKey& key);

    bool holds(const PartKey& key) const;
    std::vector<std::uint32_t> held(JobId job) const;  ///< ascending
    std::vector<JobId> jobs() const;
    std::uint64_t room_triangles() const;
    std::shared_ptr<const Territory> territory(JobId job) const;

private:
    struct Part {
        std::shared_ptr<const PartTracer> tracer;
        std::uint64_t used = 0;
    };
    struct Job {
        std::shared_ptr<const JobContext> context;
        std::uint64_t bytes = 0;
        std::map<std::uint32_t, Part> parts;  ///< that are here
        std::shared_ptr<const Territory> territory;
    };

    const PartFile& file(const PartKey& key) const;
    static std::uint64_t bytes_of(const PartFile& part);
    bool fits(std::uint64_t bytes) const { return !bytes_max_ || used_bytes_ + bytes <= *bytes_max_; }
    std::optional<Next> next_needed(std::span<const PartKey> needed) const;
    std::optional<Next> next_with_room() const;
    void renew(Job& job);

    std::optional<std::uint64_t> bytes_max_;
    std::uint64_t first_;
    std::map<JobId, Job> jobs_;
    std::uint64_t used_bytes_ = 0;
    std::uint64_t uses_ = 0;
};

}  // namespace lumenfarm::worker
