#pragma once

#include "master/discard.h"
#include "master/recovered_job.h"
#include "master/staged_result.h"
#include "proto/messages.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
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

/// Read the file's manifest or chunk. Answer: on_served.
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

/// Load and derive what the job needs, and find what earlier lives of the master have kept of it. Answer: on_prepared.
struct Prepare {
    JobRecord job;
    std::optional<double> recut_above = {};  ///< cut it anew if the work so far is shared out less evenly,
    std::uint64_t recut_hits = 0;            ///< and there are so many
};

/// Look how evenly the subspaces share the work out, and where that is more uneven, how evenly they could. Answer:
/// on_cut_measured.
struct MeasureCut {
    JobId job = 0;
    double above = 1;
};

/// Take results of a job out again, as if they had never been. Answer: on_retracted.
struct Retract {
    JobRecord record;              ///< as it is when that is done
    std::set<MachineId> machines;  ///< what they have traced
    bool all = false;              ///< or everybody
};

/// Make the result last, then add it up. Several go to the disk together. Answer: on_results_stored.
struct StoreResult {
    std::uint64_t ticket = 0;
    JobId job = 0;
    MachineId machine = 0;
    std::shared_ptr<const StagedResult> result;  ///< complete
};

/// Keep who has which lease, for the next life. No answer: when it is lost, so is the work of the lease, at most.
struct StoreLeases {
    std::vector<StoredLease> given;
    std::vector<LeaseId> ended;
};

/// Write what the job has as one solution, when so much came since the last time that it pays, or when that makes room
/// on a disk that will be full. Answer: on_snapshot_stored.
struct StoreSnapshot {
    JobId job = 0;
    JobEffort effort;
    bool last = false;  ///< of this life: however little has come since the one before
    bool disk_is_full = false;
};

/// Write the record. Answer: on_record_stored.
struct StoreRecord {
    JobRecord record;
    std::optional<Digest> basis;  ///< a job that is over goes on from this solution
};

/// Keep what the job has for when it goes on, and let go of its sums. REQUIRES: no result of the job is on its way.
/// Answer: on_put_aside.
struct PutAside {
    JobId job = 0;
    JobEffort effort;
};

/// Forget the job, which is over, and then the files. Answer: on_removed.
struct RemoveJob {
    JobId job = 0;
    std::vector<Digest> files;  ///< that no other job needs
};

/// Write the solution of what was stored, and the record with its digests. REQUIRES: no result of the job is on its
/// way. Answer: on_solution_stored.
struct StoreSolution {
    JobRecord record;
    JobEffort effort;
};

/// Say in the log what was thrown away, or who was sent off. It is counted already.
struct Discarded {
    Discard reason = Discard::protocol_error;
    std::uint64_t times = 1;
    std::string sentence;  ///< may be empty
};

using Effect =
    std::variant<Send, Close, Admit, StoreChunk, ServeManifest, ServeChunk, Prepare, MeasureCut, StoreResult, Retract,
                 StoreLeases, StoreSnapshot, StoreRecord, PutAside, RemoveJob, StoreSolution, Discarded>;
using Effects = std::vector<Effect>;

}  // namespace lumenfarm
