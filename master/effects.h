#pragma once

#include "master/job.h"
#include "proto/messages.h"

#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

/// What the master's core wants done: values that its shell (or a test) carries out in order. Slow ones are answered by
/// the event of MasterCore that is named beside them.
namespace lumenfarm {

using SessionId = std::uint64_t;
inline constexpr SessionId embedding_session = 0;  ///< the program that the master is embedded in: it always listens

struct Send {
    SessionId session = 0;
    wire::Message message;
    std::uint64_t request_id = 0;
};

/// Close the connection after what was sent has left. No on_disconnect follows.
struct Close {
    SessionId session = 0;
};

/// Look whether the scene is here and good; if so, store a record for a new job. Answer: on_admitted.
struct Admit {
    SessionId session = 0;
    std::uint64_t request_id = 0;
    wire::Submit submit;
    JobRecord record;  ///< to be stored
};

/// Verify and keep a chunk of an uploaded scene. No answer: a chunk that is not good is asked for again.
struct StoreChunk {
    wire::Chunk chunk;
};

/// Send the file's manifest or chunk, or a Refusal.
struct ServeManifest {
    SessionId session = 0;
    std::uint64_t request_id = 0;
    Digest file;
};
struct ServeChunk {
    SessionId session = 0;
    std::uint64_t request_id = 0;
    Digest file;
    std::uint32_t index = 0;
};

/// Load and derive what the job needs. Answer: on_prepared.
struct Prepare {
    JobId job = 0;
    JobSpec spec;
    Digest scene;
};

/// Write the record. A failure is logged: the job is then repeated after a restart.
struct StoreRecord {
    JobRecord record;
};

/// Encode, digest and write. Answer: on_solution_stored.
struct StoreSolution {
    JobId job = 0;
    std::shared_ptr<const Solution> solution;
};

using Effect =
    std::variant<Send, Close, Admit, StoreChunk, ServeManifest, ServeChunk, Prepare, StoreRecord, StoreSolution>;
using Effects = std::vector<Effect>;

struct StoredSolution {
    Digest digest;  ///< of the result
    Digest file;    ///< of the bytes
};

}  // namespace lumenfarm
