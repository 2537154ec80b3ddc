#pragma once

#include "common/solution/interval_set.h"
#include "master/job.h"
#include "master/ledger.h"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

/// Results that are traced a second time, by another machine, to see whether they are true. Where two differ a third
/// decides, and so on: what two of them say is true, and the others lied. Times are seconds of the caller's.
namespace lumenfarm {

using AuditId = std::uint64_t;

class Audits {
public:
    /// A set to be traced again. Results of it hold nothing but sets of the same audit.
    struct Set {
        AuditId audit = 0;
        ParticleRange range;
        std::uint64_t keep_threshold = 0;
    };
    struct Finding {
        std::vector<MachineId> honest, liars;
    };

    /// What `machine` has said of the particles is to be verified, by others that take `patience_s` at most to begin,
    /// and as much to end.
    /// `fingerprint`: result_fingerprint() with this threshold.
    void begin(JobId job, MachineId machine, std::span<const ParticleRange> ranges, double now_s, double patience_s,
               std::uint64_t keep_threshold, std::uint64_t fingerprint);

    /// Whether give() has something.
    bool has_set(JobId job, MachineId machine) const;
    /// The next set of an audit that the machine is at, or may begin. REQUIRES: has_set(), a new id.
    Set give(JobId job, MachineId machine, LeaseId id, double now_s);

    bool holds(LeaseId id) const { return given_.contains(id); }
    /// Whether the machine has a set of some audit.
    bool busy(MachineId machine) const;
    /// The audit of a result, when each claim is a part of a set that the machine has of it, and is still owed.
    std::optional<AuditId> check(MachineId machine, std::span<const Claim> claims) const;
    /// Takes the result. Says who lied once two agree. REQUIRES: check() gave the audit.
    std::optional<Finding> take(AuditId audit, std::span<const Claim> claims, std::uint64_t fingerprint);

    /// The machine will not finish what it has: others begin anew. `only`: of one lease's audit.
    void forget(MachineId machine, double now_s);
    void forget(MachineId machine, LeaseId only, double now_s);
    /// The job is interrupted: when it goes on, who was at its audits begins anew.
    void interrupt(JobId job, double now_s);
    /// Nothing that the machine has said counts any more.
    void distrust(MachineId machine, double now_s);
    /// Machines that have taken too long are given up, as if they had no part in it. Audits that nobody has begun for
    /// too long, or ended for limits::audit_patiences_max times as long, are dropped, says how many; but where two
    /// differ those that were given up may try again.
    std::uint64_t expire(double now_s);
    // Drop audits of the job, and say how many: all; those where no two differ yet; of these the ones that nobody of
    // `able` can carry on.
    std::uint64_t drop(JobId job);
    std::uint64_t drop_undisputed(JobId job);
    std::uint64_t drop_hopeless(JobId job, const std::set<MachineId>& able);

    bool any() const { return !audits_.empty(); }
    std::size_t size() const { return audits_.size(); }
    std::uint64_t pending(JobId job) const;
    std::uint64_t disputed(JobId job) const;
    std::uint64_t keep_threshold(AuditId audit) const { return audits_.at(audit).keep_threshold; }
    JobId job(AuditId audit) const { return audits_.at(audit).job; }

private:
    /// A machine that traces the audit's ranges again.
    struct Witness {
        MachineId machine = 0;
        double begun_s = 0;
        std::size_t next = 0;  ///< of the ranges
        std::uint64_t fingerprint = 0;
        std::uint64_t owed = 0;  ///< particles
    };
    struct Audit {
        JobId job = 0;
        std::vector<ParticleRange> ranges;
        std::uint64_t particles = 0;
        double patience_s = 0;
        double begun_s = 0;
        double waits_since_s = 0;  ///< for a witness
        std::uint64_t keep_threshold = 0;
        std::map<MachineId, std::uint64_t> said;  ///< fingerprints
        std::set<MachineId> given_up;
        std::optional<Witness> witness;
        bool disputed() const { return said.size() > 1; }
        bool may_begin(MachineId machine) const {
            return !witness && !said.contains(machine) && !given_up.contains(machine);
        }
    };
    struct Given {
        AuditId audit = 0;
        MachineId machine = 0;
        std::uint32_t light = 0;
        IntervalSet done;
        ParticleRange range;
    };

    static bool has_set(const Audit& audit, MachineId machine);
    static std::optional<Finding> finding(const Audit& audit);
    void dismiss(AuditId id, double now_s);
    void erase(AuditId id);
    template <class Wanted>
    std::uint64_t drop_if(JobId job, Wanted wanted);

    std::map<AuditId, Audit> audits_;
    std::map<LeaseId, Given> given_;  ///< to witnesses
    AuditId begun_ = 0;
};

}  // namespace lumenfarm
