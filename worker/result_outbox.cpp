#include "worker/result_outbox.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::worker {

void ResultOutbox::add(Parcel parcel) {
    auto kept = std::make_unique<const Parcel>(std::move(parcel));
    ParcelReader reader(*kept, ++results_made_);
    results_.push_back({results_made_, std::move(kept), reader});
}

std::optional<wire::Message> ResultOutbox::next(std::uint32_t credit, const std::function<bool(JobId)>& may_go) {
    // the parts of one result are not mixed with those of another
    for (Outgoing& outgoing : results_)
        if (outgoing.reader.begun()) return outgoing.reader.next();
    std::size_t in_flight = 0, bytes = 0;
    for (Outgoing& outgoing : results_) {
        if (!may_go(outgoing.parcel->job)) continue;
        if (!outgoing.reader.finished())
            return in_flight < credit && bytes < limits::result_bytes_in_flight ? outgoing.reader.next() : std::nullopt;
        ++in_flight;
        bytes += outgoing.parcel->bytes();
    }
    return std::nullopt;
}

void ResultOutbox::rewind() {
    for (Outgoing& outgoing : results_) outgoing.reader.rewind();
}

std::unique_ptr<const Parcel> ResultOutbox::take(std::uint64_t number) {
    const auto found = std::find_if(results_.begin(), results_.end(),
                                    [&](const Outgoing& outgoing) { return outgoing.number == number; });
    if (found == results_.end() || !found->reader.finished()) return nullptr;
    std::unique_ptr<const Parcel> parcel = std::move(found->parcel);
    results_.erase(found);
    return parcel;
}

std::size_t ResultOutbox::drop(JobId job) {
    return results_.remove_if([&](const Outgoing& outgoing) { return outgoing.parcel->job == job; });
}

std::size_t ResultOutbox::bytes() const {
    std::size_t bytes = 0;
    for (const Outgoing& outgoing : results_) bytes += outgoing.parcel->bytes();
    return bytes;
}

bool ResultOutbox::has(JobId job) const {
    return std::any_of(results_.begin(), results_.end(),
                       [&](const Outgoing& outgoing) { return outgoing.parcel->job == job; });
}

bool ResultOutbox::claims(std::uint64_t lease) const {
    return std::any_of(results_.begin(), results_.end(), [&](const Outgoing& outgoing) {
        const auto& claims = outgoing.parcel->claims;
        return std::any_of(claims.begin(), claims.end(),
                           [&](const wire::Claim& claim) { return claim.lease == lease; });
    });
}

std::map<std::uint64_t, JobId> ResultOutbox::leases() const {
    std::map<std::uint64_t, JobId> job_by_lease;
    for (const Outgoing& outgoing : results_)
        for (const wire::Claim& claim : outgoing.parcel->claims)
            job_by_lease.emplace(claim.lease, outgoing.parcel->job);
    return job_by_lease;
}

}  // namespace lumenfarm::worker
