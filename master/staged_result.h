#pragma once

#include "common/support/result.h"
#include "master/job.h"

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

/// One result: its messages, from the first part to the ResultDone, kept aside until it is complete.
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
    void add(const JobSpec& spec, const PreparedJob& prepared, wire::ResultFlights part);
    void add(const JobSpec& spec, const PreparedJob& prepared, wire::ResultWork part);

    /// Says whether the parts agree with each other and with what the result states of itself: parts, hits, balance.
    /// If so the result is complete. Errors: failed, with the sentence for the worker.
    Result<void> complete(const PreparedJob& prepared, wire::ResultDone done);
    /// Whether what was emitted, and `entered` [ticks] with flights that the result covers, was absorbed, escaped, was
    /// cut off or departs again (law 5). REQUIRES: complete.
    bool closes_with(std::int64_t entered) const;

    JobId job() const { return job_; }
    std::uint64_t number() const { return number_; }
    std::size_t bytes() const { return bytes_; }
    const std::string& fault() const { return fault_; }
    void refuse(std::string sentence);
    /// Not the worker's fault: the master has no memory for it now, or the job was put aside meanwhile.
    void refuse_blamelessly(std::string sentence);
    bool blameless() const { return blameless_; }

    /// ResultHits, ResultMap, ResultKept, ResultFlights and ResultWork as they came; the last one is the ResultDone
    /// once the result is complete.
    const std::vector<wire::Message>& messages() const { return messages_; }
    /// REQUIRES: complete.
    const wire::ResultDone& done() const { return std::get<wire::ResultDone>(messages_.back()); }

private:
    bool next_part(const wire::PartId& part, std::size_t part_bytes);
    Result<void> check(const PreparedJob& prepared, const wire::ResultDone& done) const;

    JobId job_;
    std::uint64_t number_;
    std::uint32_t parts_ = 0;
    std::size_t bytes_ = 0;
    std::uint64_t record_hits_ = 0, texel_hits_ = 0, surface_hits_ = 0;
    std::uint64_t work_hits_ = 0;
    std::uint64_t departures_ = 0;
    std::int64_t departed_ = 0;  ///< ticks
    std::string fault_;
    bool blameless_ = false;
    std::vector<wire::Message> messages_;
};

}  // namespace lumenfarm
