#pragma once

#include "common/solution/solution_file.h"
#include "common/support/limits.h"
#include "master/disk/file_store.h"
#include "master/disk/segment.h"
#include "master/job_store.h"
#include "master/job_sums.h"
#include "master/learned_cut.h"
#include "master/recovered_job.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

/// A running job on the disk: its results in segments, FOLDER/<job>-<number>, and what they add up to in memory. A
/// life of the master begins a segment of its own and never writes into an older one.
namespace lumenfarm {

/// When results are worth a snapshot: reading them again must take much longer than reading one. It is done after a
/// crash only, while each snapshot holds up the results that come meanwhile. Earlier where the disk may be full before
/// the next look.
struct SnapshotRule {
    std::uint64_t results_max = limits::results_per_snapshot_max;
    std::uint64_t times_sums = limits::snapshot_times_sums;  ///< the bytes of results over those of the job's sums
    std::uint64_t bytes_beside_sums = limits::snapshot_bytes_beside_sums;  ///< or so many more than those

    bool pays(std::uint64_t results, std::uint64_t bytes, std::uint64_t sum_bytes) const {
        return results > results_max ||
               (results > 0 && bytes >= std::min(times_sums * sum_bytes, sum_bytes + bytes_beside_sums));
    }
    /// Whether one leaves more room on the disk, and may find none itself once `coming` bytes more have come. It takes
    /// the place of `bytes` of results and of the last one, which has `last_bytes` (0: there is none); a hit of 16
    /// bytes may be the first of a texel of 48.
    static bool makes_room_in_time(std::uint64_t bytes, std::uint64_t sum_bytes, std::uint64_t last_bytes,
                                   std::uint64_t coming, std::uint64_t free_bytes) {
        const std::uint64_t needed = last_bytes > 0 ? std::min(sum_bytes, last_bytes + 3 * bytes) : sum_bytes;
        return bytes > (last_bytes > 0 ? 0 : needed) && free_bytes < needed + coming;
    }
};

class JobLog {
public:
    /// REQUIRES: the folder is there; `disk` outlives this; recover() is called before all else.
    JobLog(Disk& disk, std::filesystem::path folder, const SnapshotRule& rule, const JobRecord& job,
           std::shared_ptr<const PreparedJob> prepared);

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
    std::vector<FlightQueues::Filed> merge(const StagedResult& result) { return sums_->merge(result); }
    Result<void> undo();

    /// What was merged, as a solution.
    EncodedSolution solution(const JobEffort& effort);
    /// That, and what is in flight: what recover() reads again.
    std::vector<std::byte> snapshot_bytes(const JobEffort& effort);

    /// Of what came since the last one, or for the room on the disk. `coming_bytes`: of results of all jobs, to be
    /// expected before this is asked again.
    bool snapshot_pays(std::uint64_t coming_bytes, bool disk_is_full) const;
    /// A snapshot of so many bytes found no room: another one waits until so many are free.
    void snapshot_found_no_room(std::uint64_t bytes) { snapshot_awaits_bytes_ = bytes; }
    /// True when results came since the last snapshot, and recover() has found all of those before.
    bool has_news() const { return recovered_ && kept_results_ > 0; }
    /// Of results since the last snapshot.
    std::uint64_t kept_bytes() const { return kept_bytes_; }
    std::uint64_t next_result() const { return next_result_; }
    const std::optional<Digest>& snapshot() const { return snapshot_; }
    /// Whether each result stays on the disk until the job is over, to be retracted if need be.
    bool keeps_results() const { return keeps_results_; }
    /// The snapshot of everything merged counts: the segments before go, unless results are kept. Errors: failed.
    Result<void> begin_after(const Digest& snapshot, std::uint64_t its_bytes);
    /// Those before go, since no row names what is in them. Errors: failed.
    Result<void> begin_segments_anew();
    /// Errors: failed.
    Result<void> remove_segments();

    const JobSums& sums() const { return *sums_; }
    /// What flights are filed by; empty without subspaces.
    const Partition& cut() const { return cut_; }
    /// A cut that what was measured so far gives, where that in force is more uneven than `above`.
    LearnedCut learned_cut(double above) const;
    /// Files them anew. Does not last before a snapshot does. REQUIRES: as many subspaces.
    void cut_by(LearnedCut learned);
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
    SnapshotRule rule_;
    JobId job_;
    JobSpec spec_;
    Digest scene_;
    bool keeps_results_;
    std::shared_ptr<const PreparedJob> prepared_;
    std::optional<JobSums> sums_;  ///< from recover() on
    Partition cut_;
    std::optional<Segment> segment_;    ///< of this life, since the last snapshot
    std::set<std::uint64_t> segments_;  ///< on the disk
    std::uint64_t next_result_ = 0;
    std::uint64_t kept_results_ = 0;  ///< since the last snapshot
    std::uint64_t kept_bytes_ = 0;
    std::uint64_t appended_results_ = 0;  ///< since keep() or undo()
    std::uint64_t appended_bytes_ = 0;
    bool recovered_ = false;
    bool cut_short_ = false;
    std::optional<Digest> snapshot_;
    std::uint64_t last_snapshot_bytes_ = 0;
    std::uint64_t snapshot_awaits_bytes_ = 0;
};

}  // namespace lumenfarm
