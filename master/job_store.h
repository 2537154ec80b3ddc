#pragma once

#include "common/support/result.h"
#include "master/job.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// What outlives the master: the records of its jobs, and how many lives it has had.
namespace lumenfarm {

class JobStore {
public:
    virtual ~JobStore() = default;
    /// Writes the record for good, in place of an older one of the same job. Errors: failed.
    virtual Result<void> put(const JobRecord& record) = 0;

    struct Contents {
        std::vector<JobRecord> records;     ///< by job number
        std::vector<std::string> warnings;  ///< records that could not be read, one sentence each
    };
    /// Errors: failed.
    virtual Result<Contents> load() = 0;
    /// Number of this life: 1, then one more each time. Errors: failed.
    virtual Result<std::uint32_t> begin_life() = 0;
};

/// FOLDER/<job>.job, each the archive of a JobRecord behind a line that names the format; FOLDER/lives, a number.
class FolderJobStore : public JobStore {
public:
    explicit FolderJobStore(std::filesystem::path folder) : folder_(std::move(folder)) {}
    Result<void> put(const JobRecord& record) override;
    Result<Contents> load() override;
    Result<std::uint32_t> begin_life() override;

private:
    std::filesystem::path folder_;
};

}  // namespace lumenfarm
