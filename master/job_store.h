#pragma once

#include "common/support/result.h"
#include "master/disk/database.h"
#include "master/job.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// What outlives the master: the records of its jobs, and how many lives it has had. Not thread-safe.
namespace lumenfarm {

class JobStore {
public:
    /// Opens the database or makes it, on `vfs` as Database::open(). Errors: failed (unwritable, damaged, of a newer
    /// version), no_space.
    static Result<JobStore> open(const std::filesystem::path& file, const char* vfs = nullptr);

    /// Writes the record for good, in place of an older one of the same job. Errors: failed.
    Result<void> put(const JobRecord& record);

    struct Contents {
        std::vector<JobRecord> records;     ///< by job number
        JobId next_job = 1;                 ///< above every number that was ever given, to damaged records too
        std::vector<std::string> warnings;  ///< records that are damaged, one sentence each
    };
    /// Errors: failed.
    Result<Contents> load();
    /// Number of this life: 1, then one more each time. Errors: failed.
    Result<std::uint32_t> begin_life();

private:
    explicit JobStore(Database database) : database_(std::move(database)) {}

    Database database_;
};

}  // namespace lumenfarm
