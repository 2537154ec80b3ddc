#pragma once

#include "common/support/limits.h"
#include "proto/archive.h"
#include "proto/message_type.h"
#include "proto/messages_file.h"
#include "proto/messages_session.h"
#include "proto/shared_types.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Messages between the lumenfarm command and the master. A reply carries the request's id.
namespace lumenfarm::wire {

/// submitter -> master: start this job. Sent again with the same key it is the same job: after the chunks that the
/// reply named as missing are uploaded, and after a lost connection. Answered by SubmitReply or Refusal.
struct Submit {
    static constexpr auto type = MessageType::submit;
    std::uint64_t key = 0;  ///< random, chosen by the submitter for this job
    JobSpec spec;
    FileManifest scene;

    Submit() = default;
    Submit(std::uint64_t key_, JobSpec spec_, FileManifest scene_)
        : key(key_), spec(std::move(spec_)), scene(std::move(scene_)) {}
    bool operator==(const Submit&) const = default;
    bool valid() const { return scene.valid() && scene.total_bytes <= limits::scene_bytes_max; }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, key, spec, scene);
    }
};

/// master -> submitter. When `missing` is empty the job is accepted and stored; otherwise upload these chunks, then
/// Submit again.
struct SubmitReply {
    static constexpr auto type = MessageType::submit_reply;
    std::uint64_t job = 0;               ///< 0 while chunks are missing
    std::vector<std::uint32_t> missing;  ///< chunk indices, at most limits::chunks_max

    SubmitReply() = default;
    SubmitReply(std::uint64_t job_, std::vector<std::uint32_t> missing_) : job(job_), missing(std::move(missing_)) {}
    bool operator==(const SubmitReply&) const = default;
    bool valid() const { return (job == 0) != missing.empty(); }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, block(missing, limits::chunks_max));
    }
};

/// submitter -> master: one job, or the newest limits::jobs_listed_max. Answered by StatusReply or Refusal.
struct StatusRequest {
    static constexpr auto type = MessageType::status_request;
    std::optional<std::uint64_t> job;

    StatusRequest() = default;
    explicit StatusRequest(std::optional<std::uint64_t> job_) : job(job_) {}
    bool operator==(const StatusRequest&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job);
    }
};

enum class JobState : std::uint8_t { queued, running, paused, done, cancelled, failed };
constexpr JobState enum_last(JobState) { return JobState::failed; }
std::string_view name_of(JobState state);
/// Whether a job in this state gets no more work, unless it is extended.
constexpr bool is_over(JobState state) {
    return state == JobState::done || state == JobState::cancelled || state == JobState::failed;
}

struct JobStatus {
    std::uint64_t job = 0;
    std::string name;  ///< at most limits::peer_name_bytes_max; longer ones are cut here
    JobState state = JobState::queued;
    std::int32_t priority = 0;
    Digest scene;
    Packing packing = Packing::automatic;  ///< the one in force once the job runs
    std::uint64_t particles = 0;           ///< asked for
    std::uint64_t committed = 0;           ///< particles
    std::uint64_t leased = 0;              ///< particles
    std::uint64_t hits = 0;
    std::uint32_t workers = 0;  ///< that hold a lease of it
    double particles_per_second = 0;
    std::optional<double> eta_seconds;
    std::int64_t created_unix_seconds = 0;
    double elapsed_seconds = 0;  ///< from the first lease to now, or to the end
    double trace_seconds = 0;    ///< processor time in the tracer, summed over threads
    std::uint64_t leases_expired = 0, leases_returned = 0;
    std::uint64_t results_stale = 0, results_invalid = 0;
    std::uint64_t audits = 0;  ///< results that were traced again, and decided
    std::uint32_t liars = 0;   ///< machines that were found in it to send wrong results, and are kept out
    /// Particles that were lost with limits::losses_max workers, one after the other; at most
    /// limits::set_aside_listed_max ranges. A paused job tries them again when it is resumed.
    std::vector<ParticleRange> set_aside;
    std::optional<Digest> digest;  ///< of the result, when done
    std::string sentence;          ///< what it waits for, or why it failed; at most limits::sentence_bytes_max

    JobStatus() = default;
    bool operator==(const JobStatus&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, at_most(name, limits::peer_name_bytes_max), state, priority, scene, packing, particles,
               committed, leased, hits, workers, particles_per_second, eta_seconds, created_unix_seconds,
               elapsed_seconds, trace_seconds, leases_expired, leases_returned, results_stale, results_invalid, audits,
               liars, at_most(set_aside, limits::set_aside_listed_max), digest,
               at_most(sentence, limits::sentence_bytes_max));
    }
};

/// How often the master refused, closed or discarded something for one reason since it started. Names, so that a
/// command of another version shows reasons that it does not know.
struct ReasonCount {
    std::string group;   ///< at most limits::reason_name_bytes_max, as the following
    std::string reason;  ///< the enumerator's name
    std::uint64_t count = 0;

    ReasonCount() = default;
    ReasonCount(std::string group_, std::string reason_, std::uint64_t count_)
        : group(std::move(group_)), reason(std::move(reason_)), count(count_) {}
    bool operator==(const ReasonCount&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, at_most(group, limits::reason_name_bytes_max), at_most(reason, limits::reason_name_bytes_max),
               count);
    }
};

/// What went over a master's connections with its workers since it started, those that have ended included.
struct Traffic {
    std::uint64_t bytes_in = 0, bytes_out = 0;  ///< from and to the workers
    std::uint64_t messages_in = 0, messages_out = 0;

    Traffic() = default;
    bool operator==(const Traffic&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, bytes_in, bytes_out, messages_in, messages_out);
    }
};

/// master -> submitter, newest job first.
struct StatusReply {
    static constexpr auto type = MessageType::status_reply;
    std::vector<JobStatus> jobs;      ///< at most limits::jobs_listed_max
    std::vector<ReasonCount> counts;  ///< unless one job was asked for; at most limits::reason_counts_max
    Traffic traffic;                  ///< unless one job was asked for

    StatusReply() = default;
    explicit StatusReply(std::vector<JobStatus> jobs_, std::vector<ReasonCount> counts_ = {}, Traffic traffic_ = {})
        : jobs(std::move(jobs_)), counts(std::move(counts_)), traffic(traffic_) {}
    bool operator==(const StatusReply&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, at_most(jobs, limits::jobs_listed_max), at_most(counts, limits::reason_counts_max), traffic);
    }
};
static_assert(limits::jobs_listed_max * (512 + 24 * limits::set_aside_listed_max + limits::peer_name_bytes_max +
                                         limits::sentence_bytes_max) +
                  limits::reason_counts_max * (16 + 2 * limits::reason_name_bytes_max) + sizeof(Traffic) <=
              payload_bytes_max(MessageType::status_reply));

/// submitter -> master. Answered by WorkersReply.
struct WorkersRequest {
    static constexpr auto type = MessageType::workers_request;

    WorkersRequest() = default;
    bool operator==(const WorkersRequest&) const = default;

    template <class Archive>
    void serialize(Archive&, unsigned) {}
};

enum class WorkerState : std::uint8_t { idle, working };
constexpr WorkerState enum_last(WorkerState) { return WorkerState::working; }

struct WorkerStatus {
    std::uint64_t session = 0;
    std::string name;          ///< at most limits::peer_name_bytes_max
    std::string address;       ///< at most limits::address_bytes_max
    Role role = Role::worker;  ///< worker or relay
    WorkerState state = WorkerState::idle;
    std::uint32_t threads = 0;  ///< of a relay: of its workers
    std::uint64_t memory_bytes = 0;
    std::string isa;              ///< at most limits::isa_bytes_max
    std::uint64_t job = 0;        ///< of its newest lease, 0 for none
    std::uint32_t leases = 0;     ///< at hand
    std::uint64_t particles = 0;  ///< committed in this session
    double particles_per_second = 0;
    double connected_seconds = 0;
    double silent_seconds = 0;  ///< since the last message

    WorkerStatus() = default;
    bool operator==(const WorkerStatus&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, session, at_most(name, limits::peer_name_bytes_max), at_most(address, limits::address_bytes_max),
               role, state, threads, memory_bytes, at_most(isa, limits::isa_bytes_max), job, leases, particles,
               particles_per_second, connected_seconds, silent_seconds);
    }
};

/// master -> submitter.
struct WorkersReply {
    static constexpr auto type = MessageType::workers_reply;
    std::vector<WorkerStatus> workers;  ///< at most limits::sessions_max

    WorkersReply() = default;
    explicit WorkersReply(std::vector<WorkerStatus> workers_) : workers(std::move(workers_)) {}
    bool operator==(const WorkersReply&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, at_most(workers, limits::sessions_max));
    }
};
static_assert(limits::sessions_max *
                  (128 + limits::peer_name_bytes_max + limits::address_bytes_max + limits::isa_bytes_max) <=
              payload_bytes_max(MessageType::workers_reply));

enum class JobAction : std::uint8_t {
    pause,   ///< give out no more sets; what is done is kept
    resume,  ///< go on
    cancel,  ///< end now; what is done is kept and can be fetched
    extend,  ///< to more particles; a job that is over goes on
    remove,  ///< forget a job that is over, and its result
};
constexpr JobAction enum_last(JobAction) { return JobAction::remove; }

/// submitter -> master: do this to the job. Answered, once that lasts, by ControlReply or Refusal.
struct ControlRequest {
    static constexpr auto type = MessageType::control_request;
    std::uint64_t job = 0;
    JobAction action = JobAction::pause;
    std::uint64_t particles = 0;  ///< extend: in all from now on; else 0

    ControlRequest() = default;
    ControlRequest(std::uint64_t job_, JobAction action_, std::uint64_t particles_ = 0)
        : job(job_), action(action_), particles(particles_) {}
    bool operator==(const ControlRequest&) const = default;
    bool valid() const { return (action == JobAction::extend) == (particles > 0); }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, action, particles);
    }
};

/// master -> submitter.
struct ControlReply {
    static constexpr auto type = MessageType::control_reply;
    std::uint64_t job = 0;
    JobState state = JobState::queued;  ///< from now on: a job that had ended keeps its own when it is cancelled

    ControlReply() = default;
    ControlReply(std::uint64_t job_, JobState state_) : job(job_), state(state_) {}
    bool operator==(const ControlReply&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, state);
    }
};

/// submitter -> master: what are the files of this job? Answered by FetchReply or Refusal (not_ready while it runs).
/// The files then come by ManifestRequest and ChunkRequest.
struct FetchRequest {
    static constexpr auto type = MessageType::fetch_request;
    std::uint64_t job = 0;

    FetchRequest() = default;
    explicit FetchRequest(std::uint64_t job_) : job(job_) {}
    bool operator==(const FetchRequest&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job);
    }
};

/// master -> submitter.
struct FetchReply {
    static constexpr auto type = MessageType::fetch_reply;
    std::uint64_t job = 0;
    Digest scene;           ///< file: the compiled scene
    Digest solution_file;   ///< file: the encoded solution
    bool complete = false;  ///< false: the job ended before all particles were committed

    FetchReply() = default;
    FetchReply(std::uint64_t job_, const Digest& scene_, const Digest& solution_file_, bool complete_)
        : job(job_), scene(scene_), solution_file(solution_file_), complete(complete_) {}
    bool operator==(const FetchReply&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, scene, solution_file, complete);
    }
};

}  // namespace lumenfarm::wire
