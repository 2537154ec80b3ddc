#pragma once

#include "master/disk/file_store.h"
#include "master/disk/segment.h"
#include "master/job_store.h"
#include "master/job_sums.h"
#include "master/recovered_job.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

/// A running job on the disk: its results in segments, FOLDER/<job>-<number>, and what they add up to in memory. A
/// life of the master begins a segment of its own and never writes into an older one.
namespace lumenfarm {

class JobLog {
public:
    /// REQUIRES: the folder is there; `disk` outlives this.
    JobLog(Disk& disk, std::filesystem::path folder, const JobRecord& job, std::shared_ptr<const PreparedJob> prepared);

    /// Adds up what was kept, by earlier lives or this one. What is damaged is left out, so that its particles are
    /// traced again; a sentence for each. With subspaces so is all that came after it, since flights are numbered as
    /// they came: then cut_short(). Errors: failed (the disk: what it holds may be good).
    Result<std::vector<std::string>> recover(const JobStore::Unfinished& kept, const FileStore& files);

    /// Writes a result behind those before. sync() makes them last. Then all of them are committed to the job store,
    /// kept and merged, or all are undone. Errors: no_space, failed.
    Result<StoredResult> append(const StagedResult& result, MachineId machine);
    Result<void> sync();
    void keep();
    /// As JobSums::merge.
    std::vector<FlightQueues::Filed> merge(const StagedResult& result) { return sums_.merge(result); }
    Result<void> undo();

    /// What was merged, as a solution.
    struct Encoded {
        std::vector<std::byte> bytes;
        Digest digest;  ///< of the result
    };
    Encoded solution(const JobEffort& effort);
    /// That, and what is in flight: what recover() reads again.
    std::vector<std::byte> snapshot_bytes(const JobEffort& effort);

    /// True when what came since the last snapshot takes longer to read again than a snapshot would.
    bool snapshot_pays() const;
    /// True when results came since the last snapshot.
    bool has_news() const { return kept_results_ > 0; }
    std::uint64_t next_result() const { return next_result_; }
    const std::optional<Digest>& snapshot() const { return snapshot_; }
    /// Whether each result stays on the disk until the job is over, to be retracted if need be.
    bool keeps_results() const { return keeps_results_; }
    /// The snapshot of everything merged counts: the segments before go, unless results are kept. Errors: failed.
    Result<void> begin_after(const Digest& snapshot);
    /// Errors: failed.
    Result<void> remove_segments();

    const JobSums& sums() const { return sums_; }
    /// What flights are filed by; empty without subspaces.
    const Partition& cut() const { return cut_; }
    /// Files them anew. Does not last before a snapshot does. REQUIRES: as many subspaces.
    void cut_by(Partition cut);
    /// What recover() left out is still on the disk. A snapshot ends that.
    bool cut_short() const { return cut_short_; }

private:
    std::filesystem::path path(std::uint64_t segment) const;
    Result<void> find_segments();
    // Errors: bad_input (damaged, or gone), failed (the disk).
    Result<void> recover_snapshot(const Snapshot& snapshot, const FileStore& files);
    Result<void> recover_result(const StoredResult& stored);

    Disk& disk_;
    std::filesystem::path folder_;
    JobId job_;
    JobSpec spec_;
    Digest scene_;
    bool keeps_results_;
    JobSums sums_;
    Partition cut_;
    std::optional<Segment> segment_;    ///< of this life, since the last snapshot
    std::set<std::uint64_t> segments_;  ///< on the disk
    std::uint64_t next_result_ = 0;
    std::uint64_t kept_results_ = 0;  ///< since the last snapshot
    std::uint64_t kept_bytes_ = 0;
    std::uint64_t appended_results_ = 0;  ///< since keep() or undo()
    std::uint64_t appended_bytes_ = 0;
    bool cut_short_ = false;
    std::optional<Digest> snapshot_;
};

}  // namespace lumenfarm
