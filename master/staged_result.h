#pragma once

#include "common/support/result.h"
#include "master/job.h"

#include <cstdint>
#include <string>
#include <vector>

/// The parts of one result that have arrived, kept aside until it is complete.
namespace lumenfarm {

class StagedResult {
public:
    /// `number`: the worker's own number of the result.
    StagedResult(JobId job, std::uint64_t number) : job_(job), number_(number) {}

    /// Checks every number of the part against the job and keeps it. After the first part that is not possible nothing
    /// more is kept, and fault() says why. REQUIRES: the part is of this job and result.
    void add(const JobSpec& spec, const PreparedJob& prepared, wire::ResultHits part);
    void add(const JobSpec& spec, const PreparedJob& prepared, wire::ResultMap part);
    void add(const JobSpec& spec, const PreparedJob& prepared, wire::ResultKept part);

    /// Says whether the parts agree with each other and with what the result states of itself: parts, hits, balance.
    /// Errors: failed, with the sentence for the worker.
    Result<void> check(const wire::ResultDone& done) const;

    JobId job() const { return job_; }
    std::uint64_t number() const { return number_; }
    std::size_t bytes() const { return bytes_; }
    const std::string& fault() const { return fault_; }
    void refuse(std::string sentence);

    const std::vector<wire::ResultHits>& hits() const { return hits_; }
    const std::vector<wire::ResultMap>& maps() const { return maps_; }
    const std::vector<wire::ResultKept>& kept() const { return kept_; }

private:
    bool next_part(const wire::PartId& part, std::size_t part_bytes);

    JobId job_;
    std::uint64_t number_;
    std::uint32_t parts_ = 0;
    std::size_t bytes_ = 0;
    std::uint64_t record_hits_ = 0, texel_hits_ = 0, surface_hits_ = 0;
    std::string fault_;
    std::vector<wire::ResultHits> hits_;
    std::vector<wire::ResultMap> maps_;
    std::vector<wire::ResultKept> kept_;
};

}  // namespace lumenfarm
