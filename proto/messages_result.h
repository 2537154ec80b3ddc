#pragma once

#include "common/support/limits.h"
#include "common/transport/hit.h"
#include "proto/archive.h"
#include "proto/blocks.h"
#include "proto/message_type.h"
#include "proto/shared_types.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/// A result: parts 0 .. n - 1 (ResultHits, ResultMap, ResultKept, ResultFlights, ResultWork in any mixture), then
/// ResultDone, then the master's ResultAck. It covers ranges of one or more leases of one job and is merged whole or
/// not at all. `result` is a number of the worker's own, never used twice by one instance (Hello). After a reconnect a
/// result that has no ack is sent again from part 0; the master drops the parts of a session that ended.
namespace lumenfarm::wire {

/// Names one part of a result.
struct PartId {
    std::uint64_t job = 0;
    std::uint64_t result = 0;
    std::uint32_t sequence = 0;  ///< 0, 1, ... without gaps, under limits::parts_per_result_max

    PartId() = default;
    PartId(std::uint64_t job_, std::uint64_t result_, std::uint32_t sequence_)
        : job(job_), result(result_), sequence(sequence_) {}
    bool operator==(const PartId&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, result, sequence);
    }
};

/// worker -> master, packing `records`: hits of one light. The receiver checks each with valid_record().
struct ResultHits {
    static constexpr auto type = MessageType::result_hits;
    PartId part;
    std::uint32_t light = 0;
    std::vector<HitRecord> records;       ///< at most limits::hits_per_message_max
    std::vector<std::uint32_t> energies;  ///< attenuate: one a record, at most limits::energy_ticks_max; analog: empty

    ResultHits() = default;
    ResultHits(const PartId& part_, std::uint32_t light_, std::vector<HitRecord> records_,
               std::vector<std::uint32_t> energies_)
        : part(part_), light(light_), records(std::move(records_)), energies(std::move(energies_)) {}
    bool operator==(const ResultHits&) const = default;
    bool valid() const;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, part, light, block(records, limits::hits_per_message_max),
               block(energies, limits::hits_per_message_max));
    }
};
static_assert(limits::hits_per_message_max * (limits::hit_record_bytes + limits::hit_energy_bytes) + 256 <=
              payload_bytes_max(MessageType::result_hits));

/// worker -> master, packing `maps`: what texels and surfaces gained. Indices ascend strictly; the receiver checks them
/// against the scene with valid_map().
struct ResultMap {
    static constexpr auto type = MessageType::result_map;
    PartId part;
    std::vector<TexelDelta> texels;      ///< at most limits::texel_deltas_per_message_max
    std::vector<SurfaceDelta> surfaces;  ///< at most limits::surface_deltas_per_message_max

    ResultMap() = default;
    ResultMap(const PartId& part_, std::vector<TexelDelta> texels_, std::vector<SurfaceDelta> surfaces_)
        : part(part_), texels(std::move(texels_)), surfaces(std::move(surfaces_)) {}
    bool operator==(const ResultMap&) const = default;
    bool valid() const;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, part, block(texels, limits::texel_deltas_per_message_max),
               block(surfaces, limits::surface_deltas_per_message_max));
    }
};
static_assert(limits::texel_deltas_per_message_max * limits::texel_delta_bytes +
                  limits::surface_deltas_per_message_max * limits::surface_delta_bytes + 256 <=
              payload_bytes_max(MessageType::result_map));

/// worker -> master, packing `maps` when the job keeps hits: those under the lease's keep_threshold. (With `records`
/// the master sees every hit and chooses itself.)
struct ResultKept {
    static constexpr auto type = MessageType::result_kept;
    PartId part;
    std::vector<KeptHit> hits;  ///< at most limits::hits_per_message_max

    ResultKept() = default;
    ResultKept(const PartId& part_, std::vector<KeptHit> hits_) : part(part_), hits(std::move(hits_)) {}
    bool operator==(const ResultKept&) const = default;
    bool valid() const;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, part, block(hits, limits::hits_per_message_max));
    }
};
static_assert(limits::hits_per_message_max * limits::kept_hit_bytes + 256 <=
              payload_bytes_max(MessageType::result_kept));

/// worker -> master, strategy `subspaces`: particles that go on in a subspace whose triangles the worker does not have.
struct ResultFlights {
    static constexpr auto type = MessageType::result_flights;
    PartId part;
    std::uint32_t subspace = 0;
    std::vector<FlightRecord> flights;  ///< 1 to limits::flights_per_message_max, each possible_flight()

    ResultFlights() = default;
    ResultFlights(const PartId& part_, std::uint32_t subspace_, std::vector<FlightRecord> flights_)
        : part(part_), subspace(subspace_), flights(std::move(flights_)) {}
    bool operator==(const ResultFlights&) const = default;
    bool valid() const;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, part, subspace, block(flights, limits::flights_per_message_max));
    }
};
static_assert(limits::flights_per_message_max * limits::flight_record_bytes + 256 <=
              payload_bytes_max(MessageType::result_flights));

inline constexpr auto work_nanoseconds_max = static_cast<std::uint64_t>(limits::result_seconds_max * 1e9);

/// worker -> master, strategy `subspaces`: what following some of the particles took in the subspaces that the worker
/// holds, from which the master learns where to cut. It decides nothing else.
struct ResultWork {
    static constexpr auto type = MessageType::result_work;
    PartId part;
    std::vector<SubspaceWork> work;  ///< 1 to limits::subspaces_max, subspaces ascend strictly

    ResultWork() = default;
    ResultWork(const PartId& part_, std::vector<SubspaceWork> work_) : part(part_), work(std::move(work_)) {}
    bool operator==(const ResultWork&) const = default;
    bool valid() const;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, part, block(work, limits::subspaces_max));
    }
};
static_assert(limits::subspaces_max * sizeof(SubspaceWork) + 256 <= payload_bytes_max(MessageType::result_work));

/// What a result covers of a lease: its whole range or a part of it (law 4).
struct Claim {
    std::uint64_t lease = 0;
    std::uint32_t epoch = 0;
    ParticleRange range;

    Claim() = default;
    Claim(std::uint64_t lease_, std::uint32_t epoch_, const ParticleRange& range_)
        : lease(lease_), epoch(epoch_), range(range_) {}
    bool operator==(const Claim&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, lease, epoch, range);
    }
};

/// What holds of every balance: its batches sum to what was emitted, and it is within the limits of a job. A balance of
/// strategy `sets` is also closed(); one of `subspaces` together with what its flights brought in and take along.
bool balance_possible(const EnergyBalance& balance);

/// worker -> master: the result is whole.
struct ResultDone {
    static constexpr auto type = MessageType::result_done;
    std::uint64_t job = 0;
    std::uint64_t result = 0;
    std::vector<Claim> claims;  ///< 1 to limits::claims_per_result_max, disjoint
    std::uint32_t parts = 0;    ///< sent before; 0 when no particle hit anything
    EnergyBalance balance;      ///< over all claims; its particles are those of the lights' ranges
    double trace_seconds = 0;   ///< wall time in the tracer, summed over threads
    double cpu_seconds = 0;     ///< processor time of the same

    ResultDone() = default;
    ResultDone(std::uint64_t job_, std::uint64_t result_, std::vector<Claim> claims_, std::uint32_t parts_,
               const EnergyBalance& balance_, double trace_seconds_, double cpu_seconds_)
        : job(job_),
          result(result_),
          claims(std::move(claims_)),
          parts(parts_),
          balance(balance_),
          trace_seconds(trace_seconds_),
          cpu_seconds(cpu_seconds_) {}
    bool operator==(const ResultDone&) const = default;
    /// Ranges in bounds, the balance possible, and no more particles than the ranges hold.
    bool valid() const;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, result, at_most(claims, limits::claims_per_result_max), parts, balance, trace_seconds,
               cpu_seconds);
    }
};
static_assert(limits::claims_per_result_max * 32 + 1'024 <= payload_bytes_max(MessageType::result_done));

enum class Verdict : std::uint8_t {
    accepted,        ///< merged, and on the master's disk, or a relay has added it up and owes it: forget the result
    already_merged,  ///< particles of it are merged: nothing else of it is, forget it
    stale,           ///< a lease of it is not current any more: nothing is merged, forget it
    job_gone,        ///< the job ended or was cancelled: forget it
    invalid,         ///< its content is not possible: nothing is merged, forget it
};
constexpr Verdict enum_last(Verdict) { return Verdict::invalid; }
std::string_view name_of(Verdict verdict);

/// master -> worker: what became of a result. Whatever the verdict, the worker drops it.
struct ResultAck {
    static constexpr auto type = MessageType::result_ack;
    std::uint64_t job = 0;
    std::uint64_t result = 0;
    Verdict verdict = Verdict::accepted;
    std::string sentence;  ///< why, unless accepted; at most limits::sentence_bytes_max

    ResultAck() = default;
    ResultAck(std::uint64_t job_, std::uint64_t result_, Verdict verdict_, std::string sentence_ = {})
        : job(job_), result(result_), verdict(verdict_), sentence(std::move(sentence_)) {}
    bool operator==(const ResultAck&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, job, result, verdict, at_most(sentence, limits::sentence_bytes_max));
    }
};

}  // namespace lumenfarm::wire
