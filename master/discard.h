#pragma once

#include <cstdint>
#include <string_view>

namespace lumenfarm {

/// Why the master threw something away, or sent somebody off. Each is logged and counted; docs/operations.md says what
/// it means and what to do.
enum class Discard : std::uint8_t {
    // somebody was sent off
    unsupported_protocol,
    fingerprint_differs,
    no_threads,
    own_upstream,  ///< a relay that was told to be its own master
    farm_full,
    replaced,        ///< by a newer session of the same worker
    protocol_error,  ///< a message that is not expected in this state
    quarantined,     ///< two other workers contradict what it traced
    lied,            ///< limits::invalid_results_max results were impossible
    // a result was not merged
    result_stale,
    result_repeated,
    result_of_gone_job,
    result_invalid,
    result_unfinished,  ///< its connection was lost, or another result began, before its ResultDone
    staging_full,       ///< of a result that is stale later: no memory for its parts
    // a lease ended with particles that are still to be traced
    lease_expired,
    lease_returned,
    lease_forgotten,  ///< its worker came back and does not know it
    // others
    chunk_refused,     ///< of an upload: damaged, not asked for, or not written
    upload_displaced,  ///< by a newer one
    stored_result_damaged,
    stored_record_damaged,
    accept_failed,   ///< nobody could connect: no descriptors, no memory
    audit_hopeless,  ///< an audit that no other worker could carry out
};
constexpr Discard enum_last(Discard) { return Discard::audit_hopeless; }

/// The enumerator's name, for logs and counts.
std::string_view name_of(Discard reason);

/// What the reason is about, as `lumenfarm status` groups the counts: sent_off, results_not_merged, leases_ended,
/// dropped.
std::string_view group_of(Discard reason);

}  // namespace lumenfarm
