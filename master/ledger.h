#pragma once

#include "common/solution/interval_set.h"
#include "common/transport/tracer.h"
#include "master/lost_sets.h"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// Who traces which particles of one job, and which are done (law 4). A particle is free, leased, stored (its result
/// has arrived and is on its way to the disk) or committed. Those of a light are there from the start; behind the
/// lights may stand queues, of particles in flight, that grow. Knows no clock: times are seconds of the caller's.
namespace lumenfarm {

/// The master's epoch when it was given, and below it a number that counts up in that epoch.
using LeaseId = std::uint64_t;
constexpr LeaseId lease_id(std::uint32_t epoch, std::uint32_t number) { return LeaseId{epoch} << 32 | number; }
constexpr std::uint32_t epoch_of(LeaseId lease) { return static_cast<std::uint32_t>(lease >> 32); }

using WorkerId = std::uint64_t;   ///< of one process of a worker
using MachineId = std::uint64_t;  ///< of the PC that it runs on: the same for its next process

/// What a result says it covers: a part of a lease, or all of it.
struct Claim {
    LeaseId lease = 0;
    ParticleRange range;
};

enum class ClaimVerdict {
    current,            ///< may be committed
    stale,              ///< the lease ended, or is another worker's
    being_stored,       ///< they are on their way to the disk, from this worker or another
    already_committed,  ///< another worker was first
    invalid,            ///< outside the source, the lease, or twice in one result
};

/// A lease as it was given. What of it was committed since is not part of this.
struct GivenLease {
    LeaseId lease = 0;
    WorkerId worker = 0;
    ParticleRange range;
};

class Ledger {
public:
    /// `particles[l]` is what light l has to emit in all.
    explicit Ledger(std::vector<std::uint64_t> particles);
    /// Goes on where an earlier one ended: with what was committed and who had which leases. A lease that reaches
    /// outside its source, or that another one has already, is left out. Sources from `lights` on are queues, with what
    /// was filed in them so far.
    Ledger(std::vector<std::uint64_t> particles, std::size_t lights, std::vector<IntervalSet> committed,
           std::span<const GivenLease> leases, double now_s, double deadline_s);

    /// Of the lights nothing more is given out; leases of them last.
    void end_emission();
    /// So many more are filed in a queue.
    void grow(std::uint32_t queue, std::uint64_t count);

    // A relay's ledger is of particles that a master above lends. What is not lent counts as committed.
    /// Whether nothing of the range is lent.
    bool may_lend(const ParticleRange& range) const;
    /// They are to be traced. Those of a queue may lie beyond all that were lent before. REQUIRES: may_lend().
    void lend(const ParticleRange& range);
    std::uint64_t lent() const { return particles_.in_all() - committed_.in_all(); }
    /// Nobody is to trace any more what of the range has not arrived: leases end as far as they owe it, and it counts
    /// as committed. Gives what that was.
    std::vector<IntervalSet::Interval> withdraw(const ParticleRange& range);

    /// For whom a set is: a worker that has nothing in hand may get one that is suspected of killing workers.
    enum class Hands : bool { full, empty };
    struct NewLease {
        ParticleRange range;
        bool alone = false;  ///< the worker must get nothing else until it ends
    };
    /// Whether lease() has something.
    bool has_set(Hands hands, double now_s) const {
        return unleased() > 0 || lost_.ready(now_s, hands == Hands::empty);
    }
    /// The light of which the smallest fraction has been given out, so that an interrupted job is fair to its lights;
    /// none: all is given out.
    std::optional<std::uint32_t> next_light() const;
    /// Queues that have something to give: (how much, source), ascending.
    const std::set<std::pair<std::uint64_t, std::uint32_t>>& queues() const { return by_length_; }
    /// Leases up to `count` consecutive particles: lost ones whose wait is over; else of the source, or where none is
    /// named of next_light(). Empty when there is nothing. `due_s`: when they should be done, where that is known.
    /// REQUIRES: count > 0, a new id.
    std::optional<NewLease> lease(LeaseId id, WorkerId worker, Hands hands, std::uint64_t count, double now_s,
                                  double deadline_s, std::optional<std::uint32_t> source = {}, double due_s = 0);
    /// Leases what a straggler still owes a second time: the lease of another worker that is most overdue, was due
    /// before `due_before_s` and has no twin yet. The first commit wins. `count_max`: of its particles.
    std::optional<NewLease> lease_twin(LeaseId id, WorkerId worker, double due_before_s, double now_s,
                                       double deadline_s, std::uint64_t count_max = limits::particles_per_set_max);

    /// Says whether all the claims together may be stored. Changes nothing.
    ClaimVerdict check(WorkerId worker, std::span<const Claim> claims) const;
    /// Takes the particles from their leases, of which those end that owe nothing more, to be stored. They are never
    /// given out again. REQUIRES: check() is current.
    void store(std::span<const Claim> claims);
    /// The particles last. REQUIRES: the claims are being stored.
    void commit(std::span<const Claim> claims);

    /// Only these are committed; the others are to be traced again. REQUIRES: they are committed now.
    void retract(std::vector<IntervalSet> committed);

    /// Nothing was ever given out, and the queues are empty. Leases end.
    void restart();

    /// Takes a lease back; what it owes is given out again unless its twin still has it. Unknown ids are ignored.
    void release(LeaseId id);
    /// As release(), with a note that the particles may be what this worker was lost of. REQUIRES: the lease is held.
    void lose(LeaseId id, WorkerId worker, double now_s);
    void release_all();
    void extend(WorkerId worker, double deadline_s);
    /// Brings the deadlines of a worker that is away down to `deadline_s`.
    void shorten(WorkerId worker, double deadline_s);
    /// The worker is there, and nothing killed it.
    void forgive(WorkerId worker, double now_s);
    /// Takes back every lease whose deadline has passed, the worker being lost, and says how many they were.
    std::uint64_t expire(double now_s);

    /// Ids of the leases that ended since the last call.
    std::vector<LeaseId> take_ended() { return std::exchange(ended_, {}); }

    bool holds(LeaseId id) const { return leases_.contains(id); }
    bool held_by(WorkerId worker, LeaseId id) const;
    std::uint64_t workers() const { return leases_by_worker_.size(); }  ///< that hold a lease
    std::vector<LeaseId> leases_of(WorkerId worker) const { return {held(worker).begin(), held(worker).end()}; }
    bool has_lease(WorkerId worker) const { return leases_by_worker_.contains(worker); }
    std::uint64_t owed_by(WorkerId worker) const;  ///< particles
    std::uint64_t outstanding() const { return leases_.size(); }
    /// Particles to give out, but for lost ones.
    std::uint64_t unleased() const { return emits_ ? unleased_ : queued_; }
    std::uint64_t queued() const { return queued_; }  ///< of those, in queues
    std::uint64_t waiting(std::uint32_t source) const { return shares_[source].available; }
    const LostSets& lost() const { return lost_; }
    /// Particles that workers have, or whose results are on their way to the disk.
    std::uint64_t leased_particles() const;
    /// As LostSets.
    bool retry_set_aside(double now_s) { return lost_.retry_set_aside(now_s); }
    /// Nothing is left but particles that were set aside.
    bool only_set_aside_left() const {
        return !lost_.set_aside().empty() && leases_.empty() &&
               committed_.in_all() + lost_.set_aside_particles() == particles_.in_all();
    }
    std::size_t lights() const { return lights_; }
    std::uint64_t particles() const { return particles_.of_lights; }
    std::uint64_t committed_particles() const { return committed_.of_lights; }
    /// Filed in queues, and not committed.
    std::uint64_t in_flight() const { return particles_.of_queues - committed_.of_queues; }
    /// Every particle is committed, and none is in flight.
    bool complete() const { return committed_.in_all() == particles_.in_all(); }
    const std::vector<IntervalSet>& committed() const { return committed_by_source_; }
    /// What of the books can't be: a particle in two states or in none, a sum that is wrong. Nothing when all is well.
    /// Reads everything; for tests.
    std::optional<std::string> contradiction() const;

private:
    struct Lease {
        WorkerId worker = 0;
        std::uint32_t source = 0;
        double due_s = 0;
        double deadline_s = 0;
        LeaseId twin = 0;                 ///< 0: none
        std::vector<WorkerId> lost_with;  ///< workers that were lost with its particles, before
        std::uint32_t retries = 0;        ///< of its particles, after they were set aside
        std::vector<IntervalSet::Interval> owed;
    };
    struct Share {
        std::uint64_t particles = 0;
        std::uint64_t next = 0;                       ///< from here on nothing was ever given out
        std::vector<IntervalSet::Interval> returned;  ///< given out once, and taken back
        std::uint64_t available = 0;
    };

    struct Count {
        std::uint64_t of_lights = 0, of_queues = 0;
        std::uint64_t in_all() const { return of_lights + of_queues; }
    };

    bool is_light(std::uint32_t source) const { return source < lights_; }
    std::uint64_t& part_of(Count& count, std::uint32_t source) const {
        return is_light(source) ? count.of_lights : count.of_queues;
    }
    void restore(const GivenLease& lease, double now_s, double deadline_s);
    void find_free();
    IntervalSet::Interval take(Share& share, std::uint64_t count);
    void set_available(std::uint32_t source, std::uint64_t available);
    const std::set<LeaseId>& held(WorkerId worker) const;
    void begin_lease(LeaseId id, Lease lease);
    void end_lease(std::map<LeaseId, Lease>::iterator lease);
    /// What of the lease nobody else owes.
    std::vector<IntervalSet::Interval> owed_alone(const Lease& lease) const;
    void take_back(std::uint32_t source, const IntervalSet::Interval& piece);
    void take_away(std::uint32_t source, const IntervalSet::Interval& piece);
    void commit_unseen(std::uint32_t source, const IntervalSet::Interval& piece);
    void cut(LeaseId id, const IntervalSet::Interval& done);
    ClaimVerdict check_one(WorkerId worker, const Claim& claim) const;

    std::size_t lights_ = 0;
    bool emits_ = true;
    std::vector<Share> shares_;                                    ///< by source, as the following
    std::set<std::pair<double, std::uint32_t>> by_fraction_;       ///< lights with something to give
    std::set<std::pair<std::uint64_t, std::uint32_t>> by_length_;  ///< queues with something to give
    std::map<LeaseId, Lease> leases_;
    std::map<WorkerId, std::set<LeaseId>> leases_by_worker_;
    std::vector<IntervalSet> arrived_;  ///< being stored, or committed
    std::vector<IntervalSet> committed_by_source_;
    LostSets lost_;
    std::vector<LeaseId> ended_;
    std::uint64_t unleased_ = 0;
    std::uint64_t queued_ = 0;
    Count particles_;
    Count committed_;
};

}  // namespace lumenfarm
