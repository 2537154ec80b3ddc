#include "relay/merged_result.h"

#include "common/support/ensure.h"
#include "proto/packing.h"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace lumenfarm::relay {

MergedResult::MergedResult(JobId job, const JobSpec& spec, std::shared_ptr<const PreparedJob> prepared)
    : job_(job), hits_per_message_(spec.hits_per_message), prepared_(std::move(prepared)) {}

bool MergedResult::has_room_for(const StagedResult& result) const {
    return parcel_.bytes() + result.bytes() <= 2 * limits::result_close_bytes &&
           parcel_.balance.hits + result.done().balance.hits <= limits::hits_per_map_max / 2 &&
           2 * (parcel_.claims.size() + result.done().claims.size()) <= limits::claims_per_result_max;
}

bool MergedResult::full() const {
    return parcel_.bytes() >= limits::result_close_bytes || parcel_.balance.hits >= limits::hits_per_map_max / 4 ||
           4 * parcel_.claims.size() >= limits::claims_per_result_max;
}

void MergedResult::add(const StagedResult& result, const std::vector<wire::Claim>& claims) {
    ensure(empty() || has_room_for(result), "a parcel has bounds");
    for (const wire::Message& message : result.messages())
        std::visit(
            [&]<class M>(const M& part) {
                if constexpr (requires { this->add(part); }) this->add(part);
            },
            message);
    for (const wire::Claim& claim : claims) parcel_.add_claim(claim);
    parcel_.balance += result.done().balance;
    parcel_.trace_s = std::min(parcel_.trace_s + result.done().trace_seconds, limits::result_seconds_max);
    parcel_.cpu_s = std::min(parcel_.cpu_s + result.done().cpu_seconds, limits::result_seconds_max);
}

void MergedResult::add(const wire::ResultHits& part) { parcel_.add_hits(part.light, part.records, part.energies); }

void MergedResult::add(const wire::ResultMap& part) {
    if (!sums_) sums_.emplace(prepared_->layout);
    wire::add_map(part, sums_->texels(), sums_->surfaces());
}

void MergedResult::add(const wire::ResultKept& part) {
    parcel_.kept.insert(parcel_.kept.end(), part.hits.begin(), part.hits.end());
}

void MergedResult::add(const wire::ResultFlights& part) {
    auto& flights = parcel_.flights[part.subspace];
    flights.insert(flights.end(), part.flights.begin(), part.flights.end());
}

void MergedResult::add(const wire::ResultWork& part) {
    for (const SubspaceWork& each : part.work) parcel_.add_work(each);
}

bool MergedResult::claims(std::uint64_t lease) const {
    return std::any_of(parcel_.claims.begin(), parcel_.claims.end(),
                       [&](const wire::Claim& claim) { return claim.lease == lease; });
}

Parcel MergedResult::take() {
    if (sums_) move_sums(*sums_, parcel_);
    parcel_.job = job_;
    parcel_.hits_per_message = hits_per_message_;
    return std::exchange(parcel_, {});
}

void MergedResult::clear() {
    if (sums_) sums_->clear();
    parcel_ = {};
}

}  // namespace lumenfarm::relay
