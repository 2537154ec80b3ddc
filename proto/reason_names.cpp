#include "proto/messages_result.h"
#include "proto/messages_session.h"

namespace lumenfarm::wire {

std::string_view name_of(Role role) {
    switch (role) {
        case Role::worker: return "worker";
        case Role::submitter: return "submitter";
        case Role::relay: return "relay";
    }
    return "unknown";
}

std::string_view name_of(GoodbyeReason reason) {
    switch (reason) {
        case GoodbyeReason::done: return "done";
        case GoodbyeReason::shutting_down: return "shutting_down";
        case GoodbyeReason::unsupported_protocol: return "unsupported_protocol";
        case GoodbyeReason::refused: return "refused";
        case GoodbyeReason::farm_full: return "farm_full";
        case GoodbyeReason::protocol_error: return "protocol_error";
        case GoodbyeReason::replaced: return "replaced";
    }
    return "unknown";
}

std::string_view name_of(RefusalReason reason) {
    switch (reason) {
        case RefusalReason::bad_request: return "bad_request";
        case RefusalReason::no_such_job: return "no_such_job";
        case RefusalReason::no_such_file: return "no_such_file";
        case RefusalReason::not_ready: return "not_ready";
        case RefusalReason::full: return "full";
        case RefusalReason::failed: return "failed";
    }
    return "unknown";
}

std::string_view name_of(Verdict verdict) {
    switch (verdict) {
        case Verdict::accepted: return "accepted";
        case Verdict::already_merged: return "already_merged";
        case Verdict::stale: return "stale";
        case Verdict::job_gone: return "job_gone";
        case Verdict::invalid: return "invalid";
    }
    return "unknown";
}

}  // namespace lumenfarm::wire
