#pragma once

#include "proto/messages.h"
#include "worker/discard.h"
#include "worker/part_shelf.h"
#include "worker/trace_slot.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

/// What the worker's core wants done: values that its shell (or a test) carries out in order. Slow ones are answered by
/// the event of WorkerCore that is named beside them.
namespace lumenfarm::worker {

struct Send {
    wire::Message message;
};

/// Let a slot trace: a new set, or go on with the one it has. Answer: on_slot.
struct StartSlot {
    std::size_t slot = 0;
    SetWork work;
};
struct ContinueSlot {
    std::size_t slot = 0;
};
/// Let a slot that waits obey. Answer: on_slot.
struct TellSlot {
    std::size_t slot = 0;
    SlotAsk ask = SlotAsk::nothing;
};
/// Let a slot that traces obey after its slice; it then reports as it would have in the end. To be dropped when the
/// slot has just stopped: its report is on the way.
struct InterruptSlot {
    std::size_t slot = 0;
    SlotAsk ask = SlotAsk::nothing;
};

/// Look into the cache for a scene, a plan or a part. Answer: on_scene_loaded.
struct LoadScene {
    Digest scene;
};
/// Put a fetched file into the cache.
struct KeepScene {
    Digest scene;
    std::shared_ptr<const std::vector<std::byte>> bytes;
};
/// Decode and build what is needed. Answer: on_job_prepared.
struct PrepareJob {
    wire::JobInfo info;
    std::shared_ptr<const std::vector<std::byte>> scene_bytes;
};

/// Decode and build what is needed to trace in a subspace, or in all. Answer: on_part_prepared.
struct PreparePart {
    PartKey key;
    Digest file;
    std::shared_ptr<const JobContext> job;
    std::shared_ptr<const std::vector<std::byte>> part_bytes;
};

/// Say Goodbye and end. The master takes back what leases are left.
struct Finished {};
/// Say so and end: the master does not want this worker.
struct GiveUp {
    std::string sentence;
};

/// Say in the log what was thrown away. It is counted already.
struct Discarded {
    Discard reason = Discard::unexpected_message;
    std::uint64_t times = 1;
    std::string sentence;
};

using Effect = std::variant<Send, StartSlot, ContinueSlot, TellSlot, InterruptSlot, LoadScene, KeepScene, PrepareJob,
                            PreparePart, Finished, GiveUp, Discarded>;
using Effects = std::vector<Effect>;

}  // namespace lumenfarm::worker
