#include "master/discard.h"

namespace lumenfarm {

std::string_view name_of(Discard reason) {
    switch (reason) {
        case Discard::unsupported_protocol: return "unsupported_protocol";
        case Discard::fingerprint_differs: return "fingerprint_differs";
        case Discard::no_threads: return "no_threads";
        case Discard::own_upstream: return "own_upstream";
        case Discard::farm_full: return "farm_full";
        case Discard::replaced: return "replaced";
        case Discard::protocol_error: return "protocol_error";
        case Discard::quarantined: return "quarantined";
        case Discard::lied: return "lied";
        case Discard::result_stale: return "result_stale";
        case Discard::result_repeated: return "result_repeated";
        case Discard::result_of_gone_job: return "result_of_gone_job";
        case Discard::result_invalid: return "result_invalid";
        case Discard::result_unfinished: return "result_unfinished";
        case Discard::staging_full: return "staging_full";
        case Discard::lease_expired: return "lease_expired";
        case Discard::lease_returned: return "lease_returned";
        case Discard::lease_forgotten: return "lease_forgotten";
        case Discard::chunk_refused: return "chunk_refused";
        case Discard::upload_displaced: return "upload_displaced";
        case Discard::stored_result_damaged: return "stored_result_damaged";
        case Discard::stored_record_damaged: return "stored_record_damaged";
        case Discard::accept_failed: return "accept_failed";
        case Discard::audit_hopeless: return "audit_hopeless";
    }
    return "unknown";
}

std::string_view group_of(Discard reason) {
    switch (reason) {
        case Discard::unsupported_protocol:
        case Discard::fingerprint_differs:
        case Discard::no_threads:
        case Discard::own_upstream:
        case Discard::farm_full:
        case Discard::replaced:
        case Discard::protocol_error:
        case Discard::quarantined:
        case Discard::lied: return "sent_off";
        case Discard::result_stale:
        case Discard::result_repeated:
        case Discard::result_of_gone_job:
        case Discard::result_invalid:
        case Discard::result_unfinished:
        case Discard::staging_full: return "results_not_merged";
        case Discard::lease_expired:
        case Discard::lease_returned:
        case Discard::lease_forgotten: return "leases_ended";
        case Discard::chunk_refused:
        case Discard::upload_displaced:
        case Discard::stored_result_damaged:
        case Discard::stored_record_damaged:
        case Discard::accept_failed:
        case Discard::audit_hopeless: return "dropped";
    }
    return "unknown";
}

}  // namespace lumenfarm
