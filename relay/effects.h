#pragma once

#include "common/transport/scene_plan.h"
#include "master/effects.h"
#include "worker/effects.h"

#include <cstddef>
#include <memory>
#include <string>
#include <variant>
#include <vector>

/// What a relay's core wants done: values that its shell (or a test) carries out in order. Slow ones are answered by
/// the event of RelayCore that is named beside them.
namespace lumenfarm::relay {

/// To the master above.
struct SendUp {
    wire::Message message;
};

/// Put a fetched file where ServeManifest and ServeChunk find it. Answer: on_file_kept.
struct KeepFile {
    Digest file;
    std::shared_ptr<const std::vector<std::byte>> bytes;
};
struct RemoveFile {
    Digest file;
};

/// Derive what a job needs from its files. Answer: on_prepared.
struct PrepareLent {
    wire::JobInfo info;
    bool whole_is_here = false;  ///< strategy subspaces: the compiled scene, beside the plan
};
/// What came of that: the job; or, of a plan, the files that it names, of which the compiled scene is needed next.
struct ReadyJob {
    RecoveredJob recovered;
};
struct PlanRead {
    PartFile whole;
    std::vector<PartFile> parts;
};
using Preparation = std::variant<ReadyJob, PlanRead>;

/// Say Goodbye to everybody and end.
struct Finished {};
/// Say so and end: the master above does not want this relay.
struct GiveUp {
    std::string sentence;
};

/// Send, Close and Discarded are about the workers; ServeManifest and ServeChunk about files that were kept.
using Effect = std::variant<SendUp, Send, Close, ServeManifest, ServeChunk, KeepFile, RemoveFile, PrepareLent, Finished,
                            GiveUp, Discarded, worker::Discarded>;
using Effects = std::vector<Effect>;

}  // namespace lumenfarm::relay
