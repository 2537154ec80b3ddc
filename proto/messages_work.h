#pragma once

#include "common/support/limits.h"
#include "proto/archive.h"
#include "proto/blocks.h"
#include "proto/message_type.h"
#include "proto/shared_types.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

/// Messages that give out work.
namespace lumenfarm::wire {

/// worker -> master: the worker has room for `sets` more leases than the `leases` that have reached it in this session.
/// Replaces what an earlier Pull asked for; each Lease sent counts one off. 0 takes the wish back.
struct Pull {
    static constexpr auto type = MessageType::pull;
    std::uint32_t sets = 0;    ///< at most limits::leases_per_worker_max
    std::uint64_t leases = 0;  ///< the others are on their way: they count, too
    // of a relay; else 0 and 1
    std::uint32_t threads = 0;  ///< of its workers, at most limits::threads_behind_relay_max
    std::uint32_t threads_per_set =
        1;  ///< a set is to keep so many of them busy; 1 to limits::threads_behind_relay_max

    Pull() = default;
    explicit Pull(std::uint32_t sets_, std::uint64_t leases_ = 0) : sets(sets_), leases(leases_) {}
    Pull(std::uint32_t sets_, std::uint64_t leases_, std::uint32_t threads_, std::uint32_t threads_per_set_)
        : sets(sets_), leases(leases_), threads(threads_), threads_per_set(threads_per_set_) {}
    bool operator==(const Pull&) const = default;
    bool valid() const {
        return sets <= limits::leases_per_worker_max && threads <= limits::threads_behind_relay_max &&
               threads_per_set > 0 && threads_per_set <= limits::threads_behind_relay_max;
    }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, sets, leases, threads, threads_per_set);
    }
};

/// master -> worker: what a job is; once in a session, before the job's first Lease and before results of it that the
/// worker brought along.
struct JobInfo {
    static constexpr auto type = MessageType::job_info;
    std::uint64_t job = 0;
    Digest scene;                   ///< a chunked file: the compiled scene, or (subspaces) its plan
    std::uint64_t scene_bytes = 0;  ///< so that a worker can refuse what it has no memory for
    JobSpec spec;                   ///< its packing is the one in force: records or maps, never automatic
    double texel_m = 0;             ///< in force, > 0 (maps)
    double flush_seconds = 0;       ///< maps: at most this long between two results, > 0

    JobInfo() = default;
    JobInfo(std::uint64_t job_, const Digest& scene_, std::uint64_t scene_bytes_, JobSpec spec_, double texel_m_,
            double flush_seconds_)
        : job(job_),
          scene(scene_),
          scene_bytes(scene_bytes_),
          spec(std::move(spec_)),
          texel_m(texel_m_),
          flush_seconds(flush_seconds_) {}
    bool operator==(const JobInfo&) const = default;
    bool valid() const {
        return spec.packing != Packing::automatic && texel_m > 0 && flush_seconds > 0 && spec.hits_per_message > 0 &&
               spec.hits_per_message <= limits::hits_per_message_max && scene_bytes <= limits::scene_bytes_max;
    }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, scene, scene_bytes, spec, texel_m, flush_seconds);
    }
};

/// master -> worker: trace this set. The lease is current while the master knows (lease, epoch). With strategy
/// `subspaces` the set is of a light, or of the particles that wait in a subspace, which come along.
struct Lease {
    static constexpr auto type = MessageType::lease;
    std::uint64_t lease = 0;
    std::uint32_t epoch = 0;
    std::uint64_t job = 0;
    ParticleRange range;
    /// Hits of a higher keep_priority() are not kept by the master any more. 0 keeps none but those of priority 0.
    std::uint64_t keep_threshold = std::numeric_limits<std::uint64_t>::max();
    std::uint64_t audit = 0;  ///< a result holds sets of one audit, or (0) of none
    /// A worker's result of this set holds nothing else: another worker may be first, and then it counts for nothing.
    bool apart = false;
    std::vector<FlightRecord> flights;  ///< none, or one for each of the range; at most limits::flights_per_message_max

    Lease() = default;
    Lease(std::uint64_t lease_, std::uint32_t epoch_, std::uint64_t job_, const ParticleRange& range_,
          std::uint64_t keep_threshold_, std::uint64_t audit_ = 0)
        : lease(lease_), epoch(epoch_), job(job_), range(range_), keep_threshold(keep_threshold_), audit(audit_) {}
    bool operator==(const Lease&) const = default;
    bool valid() const {
        return valid_range(range) && (flights.empty() || flights.size() == range.count) &&
               std::all_of(flights.begin(), flights.end(), possible_flight);
    }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, lease, epoch, job, range, keep_threshold, audit, apart,
               block(flights, limits::flights_per_message_max));
    }
};
static_assert(limits::flights_per_message_max * limits::flight_record_bytes + 256 <=
              payload_bytes_max(MessageType::lease));

/// worker -> master, strategy `subspaces`: the subspaces whose triangles are at hand now. Such are preferred for it.
struct PartsHeld {
    static constexpr auto type = MessageType::parts_held;
    std::uint64_t job = 0;
    std::vector<std::uint32_t> subspaces;  ///< ascending, at most limits::subspaces_max
    std::uint64_t room_triangles = 0;      ///< for how many more there is memory
    bool all = false;                      ///< no particle goes on elsewhere: of a relay, with any of its workers

    PartsHeld() = default;
    PartsHeld(std::uint64_t job_, std::vector<std::uint32_t> subspaces_, std::uint64_t room_triangles_, bool all_)
        : job(job_), subspaces(std::move(subspaces_)), room_triangles(room_triangles_), all(all_) {}
    bool operator==(const PartsHeld&) const = default;
    bool valid() const {
        return std::adjacent_find(subspaces.begin(), subspaces.end(), std::greater_equal<>()) == subspaces.end() &&
               (subspaces.empty() || subspaces.back() < limits::subspaces_max);
    }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, block(subspaces, limits::subspaces_max), room_triangles, all);
    }
};
static_assert(limits::subspaces_max * 4 + 256 <= payload_bytes_max(MessageType::parts_held));

/// master -> worker: the job ended or was cancelled; its leases, maps and unacknowledged results are dropped.
struct JobGone {
    static constexpr auto type = MessageType::job_gone;
    std::uint64_t job = 0;

    JobGone() = default;
    explicit JobGone(std::uint64_t job_) : job(job_) {}
    bool operator==(const JobGone&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job);
    }
};

/// One holding of a lease.
struct LeaseRef {
    std::uint64_t lease = 0;
    std::uint32_t epoch = 0;

    LeaseRef() = default;
    LeaseRef(std::uint64_t lease_, std::uint32_t epoch_) : lease(lease_), epoch(epoch_) {}
    bool operator==(const LeaseRef&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, lease, epoch);
    }
};

enum class ReturnReason : std::uint8_t {
    ending,         ///< the worker goes on with other leases, or ends
    no_scene,       ///< the scene can't be fetched or does not fit the memory; the master gives this job to others
    tracer_failed,  ///< the tracer refused the job
    lost,           ///< of a relay: one of its workers after the other was lost while it had them
};
constexpr ReturnReason enum_last(ReturnReason) { return ReturnReason::lost; }

/// worker -> master: leases that this worker will not finish; nothing of them will be sent.
struct ReturnLeases {
    static constexpr auto type = MessageType::return_leases;
    ReturnReason reason = ReturnReason::ending;
    std::vector<LeaseRef> leases;  ///< 1 to limits::leases_per_worker_max

    ReturnLeases() = default;
    ReturnLeases(ReturnReason reason_, std::vector<LeaseRef> leases_) : reason(reason_), leases(std::move(leases_)) {}
    bool operator==(const ReturnLeases&) const = default;
    bool valid() const { return !leases.empty(); }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, reason, at_most(leases, limits::leases_per_worker_max));
    }
};

struct LeaseProgress {
    std::uint64_t job = 0;
    std::uint64_t lease = 0;
    std::uint64_t particles = 0;  ///< traced so far

    LeaseProgress() = default;
    LeaseProgress(std::uint64_t job_, std::uint64_t lease_, std::uint64_t particles_)
        : job(job_), lease(lease_), particles(particles_) {}
    bool operator==(const LeaseProgress&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, lease, particles);
    }
};

/// worker -> master: the first message after Welcome, with every lease that the worker still holds or has results of
/// (the master takes all its other leases back). Results of these jobs follow once a JobInfo has come in this session,
/// or are dropped when a JobGone comes. And now and then: how far the leases at hand are, for estimates.
struct Progress {
    static constexpr auto type = MessageType::progress;
    double particles_per_second = 0;    ///< over all threads, >= 0
    std::vector<LeaseProgress> leases;  ///< at most limits::leases_per_worker_max

    Progress() = default;
    Progress(double particles_per_second_, std::vector<LeaseProgress> leases_)
        : particles_per_second(particles_per_second_), leases(std::move(leases_)) {}
    bool operator==(const Progress&) const = default;
    bool valid() const { return particles_per_second >= 0; }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, particles_per_second, at_most(leases, limits::leases_per_worker_max));
    }
};

/// master -> worker: close the results at hand of this job at the next slice, send them, and return the rest of its
/// leases; the job takes what is done and ends. job 0: of every job, and pull no more.
struct Drain {
    static constexpr auto type = MessageType::drain;
    std::uint64_t job = 0;

    Drain() = default;
    explicit Drain(std::uint64_t job_) : job(job_) {}
    bool operator==(const Drain&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job);
    }
};

static_assert(limits::leases_per_worker_max * 24 + 1'024 <= payload_bytes_max(MessageType::progress));

}  // namespace lumenfarm::wire
