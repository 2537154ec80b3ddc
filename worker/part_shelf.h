#pragma once

#include "common/transport/territory.h"
#include "worker/job_context.h"
#include "worker/piece.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Which subspaces of which jobs this worker has the triangles of, and which come next, within its memory
/// (docs/subspaces.md). A scene that fits it comes whole. Knows no file and no thread.
namespace lumenfarm::worker {

struct PartKey {
    JobId job = 0;
    std::uint32_t subspace = 0;  ///< none: the whole scene

    bool is_whole() const { return subspace == none; }
    std::string text() const;  ///< for logs
    auto operator<=>(const PartKey&) const = default;
};

inline PartKey whole_of(const PartKey& part) { return {part.job, none}; }

class PartShelf {
public:
    /// `bytes_max`: for the parts and plans of all jobs together; none: no limit. `first`: which part a job begins
    /// with, so that workers that can't have all have different ones. `parts_only`: no scene comes whole.
    explicit PartShelf(std::optional<std::uint64_t> bytes_max, std::uint64_t first = 0, bool parts_only = false)
        : bytes_max_(bytes_max), first_(first), parts_only_(parts_only) {}

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
    /// What to bring in next: a whole scene that fits, the first of `needed` that is missing, or what there is room
    /// for. Others go for one that is needed, the one that was used longest ago first, but not what is needed before
    /// it. Keys of jobs that are not open are ignored.
    std::optional<Next> next(std::span<const PartKey> needed) const;
    /// REQUIRES: the piece is what the key says.
    void put(const PartKey& key, Piece piece);
    void give_up(const PartKey& key);
    /// From now on the job's scene comes in parts.
    void fail_whole(JobId job);
    /// Particles of it are going to be traced.
    void use(const PartKey& key);

    bool holds(const PartKey& key) const;              ///< alone or in the whole scene
    std::vector<std::uint32_t> held(JobId job) const;  ///< ascending
    std::vector<JobId> jobs() const;
    std::uint64_t room_triangles() const;
    std::shared_ptr<const Territory> territory(JobId job) const;

private:
    struct Part {
        Piece piece;
        std::uint64_t used = 0;
    };
    struct Job {
        std::shared_ptr<const JobContext> context;
        std::uint64_t bytes = 0;
        bool whole_failed = false;            ///< could not be had: the scene comes in parts
        std::map<std::uint32_t, Part> parts;  ///< that are here; the whole scene: none
        std::shared_ptr<const Territory> territory;
    };

    const PartFile& file(const PartKey& key) const;
    std::uint64_t bytes_of(JobId id, const Job& job) const;
    bool takes_whole(JobId id, const Job& job) const;
    static std::uint64_t bytes_of(const PartFile& part);
    bool fits(std::uint64_t bytes) const { return !bytes_max_ || used_bytes_ + bytes <= *bytes_max_; }
    std::optional<Next> next_whole() const;
    std::optional<Next> next_needed(std::span<const PartKey> needed) const;
    std::optional<Next> next_with_room() const;
    void renew(Job& job);

    std::optional<std::uint64_t> bytes_max_;
    std::uint64_t first_;
    bool parts_only_;
    std::map<JobId, Job> jobs_;
    std::uint64_t used_bytes_ = 0;
    std::uint64_t uses_ = 0;
};

}  // namespace lumenfarm::worker
