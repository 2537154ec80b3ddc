#pragma once

#include "common/net/close_reason.h"
#include "common/support/tally.h"
#include "proto/messages_result.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace lumenfarm::worker {

/// Why the worker threw something away. Each is logged and counted; docs/operations.md says what it means and what to
/// do.
enum class Discard : std::uint8_t {
    // what was traced
    result_refused,      ///< the master's verdict, which is counted, too
    result_of_gone_job,  ///< closed results and open ones
    result_undelivered,  ///< the worker ended before the master's answer
    // what was to be traced
    set_of_gone_job,
    set_outlived,       ///< the connection was away for so long that others have it
    set_not_traceable,  ///< the job can't be traced here: its sets go back
    memory_too_small,   ///< for the largest subspace of a job
    // messages
    unexpected_message,  ///< nobody here waits for it
    damaged_chunk,
    // scenes
    scene_not_fetched,
    scene_not_cached,
    cached_scene_damaged,
    cached_scene_displaced,  ///< by newer ones
    part_given_up,           ///< triangles of a subspace, or of all, for others
};
constexpr Discard enum_last(Discard) { return Discard::part_given_up; }

/// The enumerator's name, for logs and counts.
std::string_view name_of(Discard reason);

/// What was discarded, refused and closed since the worker started, by reason.
struct WorkerCounts {
    Tally<Discard> discards;
    Tally<wire::Verdict> verdicts;
    Tally<net::CloseReason> closes;
    Tally<wire::WireError> refused_frames;  ///< of the closes that are a protocol_error

    void count(const net::Closed& closed);
    /// One line of what has come up.
    std::string text() const;
};

}  // namespace lumenfarm::worker
