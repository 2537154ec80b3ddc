#include "common/net/close_reason.h"

namespace lumenfarm::net {

std::string_view name_of(CloseReason reason) {
    switch (reason) {
        case CloseReason::by_us: return "by_us";
        case CloseReason::by_peer: return "by_peer";
        case CloseReason::goodbye: return "goodbye";
        case CloseReason::half_frame: return "half_frame";
        case CloseReason::no_hello: return "no_hello";
        case CloseReason::silent: return "silent";
        case CloseReason::write_stalled: return "write_stalled";
        case CloseReason::outbox_full: return "outbox_full";
        case CloseReason::protocol_error: return "protocol_error";
        case CloseReason::network_error: return "network_error";
    }
    return "unknown";
}

}  // namespace lumenfarm::net
