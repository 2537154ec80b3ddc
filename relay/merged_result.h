#pragma once

#include "master/job.h"
#include "master/staged_result.h"
#include "worker/parcel.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

/// What the results of a relay's workers add up to, until it is handed up: sums are added to sums, which are integers
/// (law 3); hits and particles in flight go along as they are.
namespace lumenfarm::relay {

class MergedResult {
public:
    MergedResult(JobId job, const JobSpec& spec, std::shared_ptr<const PreparedJob> prepared);

    /// Whether the result may be added: a parcel has bounds.
    bool has_room_for(const StagedResult& result) const;
    /// `claims`: what the result covers of the leases of the master above. REQUIRES: has_room_for(), or nothing was
    /// added since the last take().
    void add(const StagedResult& result, const std::vector<wire::Claim>& claims);

    const PreparedJob& prepared() const { return *prepared_; }
    bool empty() const { return parcel_.claims.empty(); }
    bool full() const;
    bool claims(std::uint64_t lease) const;
    const std::vector<wire::Claim>& claims() const { return parcel_.claims; }
    /// All that was added. Nothing is left.
    Parcel take();
    void clear();

private:
    void add(const wire::ResultHits& part);
    void add(const wire::ResultMap& part);
    void add(const wire::ResultKept& part);
    void add(const wire::ResultFlights& part);
    void add(const wire::ResultWork& part);

    JobId job_;
    std::uint32_t hits_per_message_;
    std::shared_ptr<const PreparedJob> prepared_;
    Parcel parcel_;
    std::optional<LightMap> sums_;  ///< once some came
};

}  // namespace lumenfarm::relay
