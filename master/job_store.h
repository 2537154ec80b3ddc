#pragma once

#include "common/support/result.h"
#include "master/disk/database.h"
#include "master/job.h"
#include "master/ledger.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

/// What outlives the master, but for the bulk: its jobs, who had which leases, and where results lie on the disk. What
/// a call has written lasts when it returns, and all of it counts or nothing. Every row has a checksum (XXH3-64), since
/// SQLite verifies its own structure but not the bytes of a row; rows that are damaged are left out. Not thread-safe.
/// Errors everywhere: no_space, failed.
namespace lumenfarm {

/// A result of a job that runs: `number` counts up in a job, its bytes lie in a segment (docs/segment_file.md).
struct StoredResult {
    JobId job = 0;
    std::uint64_t number = 0;
    std::uint64_t segment = 0;
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
    std::uint64_t checksum = 0;  ///< XXH3-64 of the bytes
    MachineId machine = 0;
    bool operator==(const StoredResult&) const = default;
};

struct StoredLease {
    JobId job = 0;
    GivenLease lease;
};

/// The results of a job under `next_result`, added up as a solution in a file.
struct Snapshot {
    Digest file;
    std::uint64_t next_result = 0;
};

class JobStore {
public:
    /// Opens the database or makes it, on `vfs` as Database::open(). Errors also: failed (damaged, of a newer version).
    static Result<JobStore> open(const std::filesystem::path& file, const char* vfs = nullptr);

    struct Contents {
        std::vector<JobRecord> records;     ///< by job number
        JobId next_job = 1;                 ///< above every number that was ever given, to damaged records too
        std::vector<std::string> warnings;  ///< records that are damaged, one sentence each
    };
    Result<Contents> load();
    /// Number of this life: 1, then one more each time.
    Result<std::uint32_t> begin_life();

    /// Writes the record in place of an older one of the same job.
    Result<void> put(const JobRecord& record);
    /// The record of a job that is over; nothing else is kept of it.
    Result<void> finish(const JobRecord& record);
    /// The record of a job that was over and goes on from its solution.
    Result<void> reopen(const JobRecord& record, const Digest& solution);
    /// Forgets a job that is over. Its number is never given again.
    Result<void> remove(JobId job);

    /// The commit of results (law 6). A lease that is given and has ended is not written.
    Result<void> commit(std::span<const StoredResult> results, std::span<const StoredLease> given,
                        std::span<const LeaseId> ended);
    /// The snapshot takes the place of an older one and of the results in it.
    /// `keep_results`: they stay beside it. `end_leases`: those of the job are none any more.
    Result<void> checkpoint(JobId job, const Snapshot& snapshot, bool keep_results, bool end_leases);
    /// Writes the record, and forgets the job's snapshot and the results of the machines, or all.
    Result<void> retract(const JobRecord& record, const std::set<MachineId>& machines, bool all_results);

    /// What is kept of a job that is not over.
    struct Unfinished {
        std::optional<Snapshot> snapshot;
        std::vector<StoredResult> results;  ///< by number
        std::uint64_t next_result = 0;      ///< above every number that was ever given
        std::vector<GivenLease> leases;
        std::uint64_t damaged = 0;         ///< rows of the snapshot and of results that were left out
        std::uint64_t damaged_leases = 0;  ///< rows that were left out
    };
    Result<Unfinished> unfinished(JobId job);

private:
    explicit JobStore(Database database) : database_(std::move(database)) {}
    Result<void> write_record(const JobRecord& record);
    Result<void> write_snapshot(JobId job, const Snapshot& snapshot);
    Result<void> remove_rows(const char* sql, std::span<const std::uint64_t> keys);
    Result<void> read_snapshot(JobId job, Unfinished& into);
    Result<void> read_results(JobId job, Unfinished& into);
    Result<void> read_leases(JobId job, Unfinished& into);

    Database database_;
};

}  // namespace lumenfarm
