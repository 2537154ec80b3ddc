#pragma once

#include "common/net/close_reason.h"
#include "common/support/tally.h"
#include "master/discard.h"
#include "proto/messages_client.h"

#include <vector>

namespace lumenfarm {

/// What was refused, closed and discarded since the master started, by reason, and what went through.
struct FarmCounts {
    Tally<Discard> discards;
    Tally<net::CloseReason> closes;
    Tally<wire::WireError> refused_frames;  ///< of the closes that are a protocol_error
    Tally<wire::RefusalReason> refused_requests;
    wire::Traffic traffic;  ///< the shell keeps it

    void count(const net::Closed& closed);
    /// Every reason of every group, as `lumenfarm status` shows them.
    std::vector<wire::ReasonCount> listed() const;
};

}  // namespace lumenfarm
