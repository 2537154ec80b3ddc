#include "master/ledger.h"

#include "common/support/ensure.h"

#include <algorithm>

namespace lumenfarm {

namespace {

using Interval = IntervalSet::Interval;

bool inside(const Interval& part, const Interval& whole) { return part.begin >= whole.begin && part.end <= whole.end; }

Interval interval_of(const ParticleRange& range) { return {range.first, range.first + range.count}; }

bool any_overlap(std::span<const Claim> claims) {
    std::vector<ParticleRange> ranges;
    ranges.reserve(claims.size());
    for (const Claim& claim : claims) ranges.push_back(claim.range);
    std::sort(ranges.begin(), ranges.end(), [](const ParticleRange& a, const ParticleRange& b) {
        return std::pair(a.source, a.first) < std::pair(b.source, b.first);
    });
    for (std::size_t i = 1; i < ranges.size(); ++i) {
        const ParticleRange& before = ranges[i - 1];
        if (before.source == ranges[i].source && before.first + before.count > ranges[i].first) return true;
    }
    return false;
}

}  // namespace

Ledger::Ledger(std::vector<std::uint64_t> particles) : Ledger(particles, particles.size(), {}, {}, 0, 0) {}

Ledger::Ledger(std::vector<std::uint64_t> particles, std::size_t lights, std::vector<IntervalSet> committed,
               std::span<const GivenLease> leases, double now_s, double deadline_s)
    : lights_(lights), shares_(particles.size()), committed_by_source_(std::move(committed)) {
    committed_by_source_.resize(particles.size());
    arrived_ = committed_by_source_;
    for (std::uint32_t source = 0; source < particles.size(); ++source) {
        shares_[source].particles = particles[source];
        part_of(particles_, source) += particles[source];
        part_of(committed_, source) += committed_by_source_[source].size();
    }
    for (const GivenLease& lease : leases) restore(lease, now_s, deadline_s);
    find_free();
}

void Ledger::end_emission() {
    emits_ = false;
    for (const LostSet& lost : lost_.extract_below(static_cast<std::uint32_t>(lights_)))
        take_back(lost.range.source, interval_of(lost.range));
}

void Ledger::take_back(std::uint32_t source, const Interval& piece) {
    shares_[source].returned.push_back(piece);
    set_available(source, shares_[source].available + (piece.end - piece.begin));
}

void Ledger::grow(std::uint32_t queue, std::uint64_t count) {
    ensure(!is_light(queue) && queue < shares_.size(), "queues grow");
    shares_[queue].particles += count;
    particles_.of_queues += count;
    set_available(queue, shares_[queue].available + count);
}

/// The lease owes what of it has not arrived.
void Ledger::restore(const GivenLease& given, double now_s, double deadline_s) {
    const ParticleRange& range = given.range;
    if (given.lease == 0 || leases_.contains(given.lease)) return;
    const std::uint64_t particles = range.source < shares_.size() ? shares_[range.source].particles : 0;
    if (range.first >= particles || range.count > particles - range.first) return ended_.push_back(given.lease);
    std::vector<Interval> owed = arrived_[range.source].gaps(range.first, range.first + range.count);
    const auto is_owed_by_another = [&](const Interval& piece) {
        return std::any_of(leases_.begin(), leases_.end(), [&](const auto& entry) {
            const Lease& other = entry.second;
            return other.source == range.source &&
                   std::any_of(other.owed.begin(), other.owed.end(),
                               [&](const auto& o) { return o.begin < piece.end && piece.begin < o.end; });
        });
    };
    if (owed.empty() || std::any_of(owed.begin(), owed.end(), is_owed_by_another)) {
        ended_.push_back(given.lease);
        return;
    }
    begin_lease(given.lease, Lease{given.worker, range.source, now_s, deadline_s, 0, {}, 0, std::move(owed)});
}

/// What is neither leased nor has arrived.
void Ledger::find_free() {
    std::vector<IntervalSet> bound = arrived_;
    for (const auto& [id, lease] : leases_)
        for (const Interval& piece : lease.owed)
            ensure(bound[lease.source].insert(piece.begin, piece.end), "a particle is leased once");
    for (std::uint32_t source = 0; source < shares_.size(); ++source) {
        Share& share = shares_[source];
        const auto taken = bound[source].intervals();
        share.next = taken.empty() ? 0 : taken.back().end;
        share.returned = bound[source].gaps(0, share.next);
        std::reverse(share.returned.begin(), share.returned.end());  // given out from the back
        set_available(source, share.particles - bound[source].size());
    }
}

void Ledger::set_available(std::uint32_t source, std::uint64_t available) {
    Share& share = shares_[source];
    unleased_ += available - share.available;
    if (!is_light(source)) {
        queued_ += available - share.available;
        by_length_.erase({share.available, source});
        share.available = available;
        if (available > 0) by_length_.emplace(available, source);
        return;
    }
    const auto key = [&] {
        const double given = static_cast<double>(share.particles - share.available);
        return std::pair(given / static_cast<double>(share.particles), source);
    };
    if (share.available > 0) by_fraction_.erase(key());
    share.available = available;
    if (available > 0) by_fraction_.insert(key());
}

std::optional<std::uint32_t> Ledger::next_light() const {
    if (!emits_ || by_fraction_.empty()) return std::nullopt;
    return by_fraction_.begin()->second;
}

Interval Ledger::take(Share& share, std::uint64_t count) {
    if (share.returned.empty()) {
        const Interval taken{share.next, std::min(share.particles, share.next + count)};
        share.next = taken.end;
        return taken;
    }
    Interval& last = share.returned.back();
    const Interval taken{last.begin, std::min(last.end, last.begin + count)};
    last.begin = taken.end;
    if (last.begin == last.end) share.returned.pop_back();
    return taken;
}

std::optional<Ledger::NewLease> Ledger::lease(LeaseId id, WorkerId worker, Hands hands, std::uint64_t count,
                                              double now_s, double deadline_s, std::optional<std::uint32_t> source,
                                              double due_s) {
    due_s = std::max(due_s, now_s);
    ensure(count > 0 && id != 0 && !leases_.contains(id), "a lease is new and not empty");
    if (const auto lost = lost_.take(now_s, hands == Hands::empty, count)) {
        begin_lease(id, Lease{worker,
                              lost->range.source,
                              due_s,
                              deadline_s,
                              0,
                              lost->lost_with,
                              lost->retries,
                              {interval_of(lost->range)}});
        return NewLease{lost->range, lost->alone()};
    }
    if (!source) source = next_light();
    if (!source || shares_[*source].available == 0) return std::nullopt;
    Share& share = shares_[*source];
    const Interval taken = take(share, std::min(count, share.available));
    set_available(*source, share.available - (taken.end - taken.begin));
    begin_lease(id, Lease{worker, *source, due_s, deadline_s, 0, {}, 0, {taken}});
    return NewLease{{*source, taken.begin, taken.end - taken.begin}};
}

std::optional<Ledger::NewLease> Ledger::lease_twin(LeaseId id, WorkerId worker, double due_before_s, double now_s,
                                                   double deadline_s, std::uint64_t count_max) {
    ensure(id != 0 && !leases_.contains(id), "a lease is new");
    auto latest = leases_.end();
    for (auto it = leases_.begin(); it != leases_.end(); ++it) {
        const Lease& lease = it->second;
        if (lease.twin != 0 || lease.worker == worker || lease.due_s >= due_before_s) continue;
        if (lease.owed.front().end - lease.owed.front().begin > count_max) continue;
        if (latest == leases_.end() || lease.due_s < latest->second.due_s) latest = it;
    }
    if (latest == leases_.end()) return std::nullopt;
    Lease& straggler = latest->second;
    const Interval owed = straggler.owed.front();
    straggler.twin = id;
    begin_lease(id, Lease{worker,
                          straggler.source,
                          now_s,
                          deadline_s,
                          latest->first,
                          straggler.lost_with,
                          straggler.retries,
                          {owed}});
    return NewLease{{straggler.source, owed.begin, owed.end - owed.begin}, straggler.lost_with.size() > 1};
}

ClaimVerdict Ledger::check_one(WorkerId worker, const Claim& claim) const {
    const ParticleRange& range = claim.range;
    if (range.source >= shares_.size() || range.count == 0) return ClaimVerdict::invalid;
    if (range.first + range.count < range.first) return ClaimVerdict::invalid;
    const Interval part = interval_of(range);
    if (committed_by_source_[range.source].overlaps(part.begin, part.end)) return ClaimVerdict::already_committed;
    if (arrived_[range.source].overlaps(part.begin, part.end)) return ClaimVerdict::being_stored;
    const auto found = leases_.find(claim.lease);
    if (found == leases_.end() || found->second.worker != worker) return ClaimVerdict::stale;
    if (found->second.source != range.source) return ClaimVerdict::invalid;
    const auto& owed = found->second.owed;
    const bool owes = std::any_of(owed.begin(), owed.end(), [&](const Interval& piece) { return inside(part, piece); });
    return owes ? ClaimVerdict::current : ClaimVerdict::invalid;
}

ClaimVerdict Ledger::check(WorkerId worker, std::span<const Claim> claims) const {
    if (claims.empty()) return ClaimVerdict::invalid;
    for (const Claim& claim : claims) {
        const ClaimVerdict verdict = check_one(worker, claim);
        if (verdict != ClaimVerdict::current) return verdict;
    }
    return any_overlap(claims) ? ClaimVerdict::invalid : ClaimVerdict::current;
}

void Ledger::store(std::span<const Claim> claims) {
    for (const Claim& claim : claims) {
        const Interval done = interval_of(claim.range);
        ensure(arrived_[claim.range.source].insert(done.begin, done.end), "a particle is stored once");
        const auto found = leases_.find(claim.lease);
        ensure(found != leases_.end(), "a claim that is stored has a lease");
        const LeaseId twin = found->second.twin;
        cut(claim.lease, done);
        if (twin != 0) cut(twin, done);
    }
}

void Ledger::commit(std::span<const Claim> claims) {
    for (const Claim& claim : claims) {
        const Interval done = interval_of(claim.range);
        ensure(arrived_[claim.range.source].covers(done.begin, done.end), "what is committed was stored");
        ensure(committed_by_source_[claim.range.source].insert(done.begin, done.end), "a particle is committed once");
        part_of(committed_, claim.range.source) += claim.range.count;
    }
}

void Ledger::retract(std::vector<IntervalSet> committed) {
    committed.resize(committed_by_source_.size());
    for (std::uint32_t source = 0; source < committed.size(); ++source) {
        IntervalSet arrived = committed[source];
        for (const Interval& piece : arrived_[source].intervals())
            for (const Interval& on_its_way : committed_by_source_[source].gaps(piece.begin, piece.end))
                ensure(arrived.insert(on_its_way.begin, on_its_way.end), "what is left was committed");
        for (const Interval& piece : committed_by_source_[source].intervals())
            for (const Interval& taken : committed[source].gaps(piece.begin, piece.end)) {
                part_of(committed_, source) -= taken.end - taken.begin;
                take_back(source, taken);
            }
        arrived_[source] = std::move(arrived);
        committed_by_source_[source] = std::move(committed[source]);
    }
}

void Ledger::restart() {
    std::vector<LeaseId> ended = take_ended();
    std::vector<std::uint64_t> particles(shares_.size());
    for (const auto& [id, lease] : leases_) ended.push_back(id);
    for (std::size_t light = 0; light < lights_; ++light) particles[light] = shares_[light].particles;
    *this = Ledger(std::move(particles), lights_, {}, {}, 0, 0);
    ended_ = std::move(ended);
}

bool Ledger::may_lend(const ParticleRange& range) const {
    if (range.source >= shares_.size()) return false;
    const std::uint64_t end = range.first + range.count, known = shares_[range.source].particles;
    if (is_light(range.source) && end > known) return false;
    return range.first >= known || committed_by_source_[range.source].covers(range.first, std::min(end, known));
}

void Ledger::lend(const ParticleRange& range) {
    ensure(may_lend(range), "particles are lent once");
    const Interval lent = interval_of(range);
    Share& share = shares_[range.source];
    if (lent.end > share.particles) {
        const Interval grown{share.particles, lent.end};
        share.particles = share.next = lent.end;
        part_of(particles_, range.source) += grown.end - grown.begin;
        commit_unseen(range.source, grown);
    }
    arrived_[range.source].erase(lent.begin, lent.end);
    committed_by_source_[range.source].erase(lent.begin, lent.end);
    part_of(committed_, range.source) -= range.count;
    take_back(range.source, lent);
}

std::vector<Interval> Ledger::withdraw(const ParticleRange& range) {
    std::vector<LeaseId> leased;
    for (const auto& [id, lease] : leases_)
        if (lease.source == range.source) leased.push_back(id);
    std::vector<Interval> withdrawn = arrived_[range.source].gaps(range.first, range.first + range.count);
    for (const Interval& piece : withdrawn) {
        for (const LeaseId id : leased) cut(id, piece);
        take_away(range.source, piece);
        lost_.remove({range.source, piece.begin, piece.end - piece.begin});
        commit_unseen(range.source, piece);
    }
    return withdrawn;
}

/// What of the piece is free is no more.
void Ledger::take_away(std::uint32_t source, const Interval& piece) {
    Share& share = shares_[source];
    std::vector<Interval> left;
    std::uint64_t taken = 0;
    for (const Interval& free : share.returned) {
        const Interval common{std::max(free.begin, piece.begin), std::min(free.end, piece.end)};
        if (common.begin >= common.end) {
            left.push_back(free);
            continue;
        }
        taken += common.end - common.begin;
        if (free.begin < common.begin) left.push_back({free.begin, common.begin});
        if (common.end < free.end) left.push_back({common.end, free.end});
    }
    share.returned = std::move(left);
    set_available(source, share.available - taken);
}

void Ledger::commit_unseen(std::uint32_t source, const Interval& piece) {
    ensure(arrived_[source].insert(piece.begin, piece.end), "what is not lent has not arrived");
    ensure(committed_by_source_[source].insert(piece.begin, piece.end), "what is not lent is not committed");
    part_of(committed_, source) += piece.end - piece.begin;
}

/// Removes `done` from what the lease owes; a lease that owes nothing ends.
void Ledger::cut(LeaseId id, const Interval& done) {
    const auto found = leases_.find(id);
    if (found == leases_.end()) return;
    std::vector<Interval> rest;
    for (const Interval& piece : found->second.owed) {
        if (done.end <= piece.begin || done.begin >= piece.end) {
            rest.push_back(piece);
            continue;
        }
        if (piece.begin < done.begin) rest.push_back({piece.begin, done.begin});
        if (done.end < piece.end) rest.push_back({done.end, piece.end});
    }
    found->second.owed = std::move(rest);
    if (found->second.owed.empty()) end_lease(found);
}

void Ledger::begin_lease(LeaseId id, Lease lease) {
    leases_by_worker_[lease.worker].insert(id);
    leases_.emplace(id, std::move(lease));
}

void Ledger::end_lease(std::map<LeaseId, Lease>::iterator lease) {
    if (const auto twin = leases_.find(lease->second.twin); twin != leases_.end()) twin->second.twin = 0;
    ended_.push_back(lease->first);
    const auto of_worker = leases_by_worker_.find(lease->second.worker);
    of_worker->second.erase(lease->first);
    if (of_worker->second.empty()) leases_by_worker_.erase(of_worker);
    leases_.erase(lease);
}

std::vector<Interval> Ledger::owed_alone(const Lease& lease) const {
    const auto twin = leases_.find(lease.twin);
    std::vector<Interval> alone = lease.owed;
    if (twin == leases_.end()) return alone;
    std::erase_if(alone, [&](const Interval& piece) {
        return std::any_of(twin->second.owed.begin(), twin->second.owed.end(),
                           [&](const Interval& other) { return inside(piece, other); });
    });
    return alone;
}

void Ledger::release(LeaseId id) {
    const auto found = leases_.find(id);
    if (found == leases_.end()) return;
    const Lease& lease = found->second;
    for (const Interval& piece : owed_alone(lease)) take_back(lease.source, piece);
    end_lease(found);
}

void Ledger::lose(LeaseId id, WorkerId worker, double now_s) {
    const auto found = leases_.find(id);
    const Lease& lease = found->second;
    if (!emits_ && is_light(lease.source)) return release(id);
    std::vector<WorkerId> lost_with = lease.lost_with;
    lost_with.push_back(worker);
    for (const Interval& piece : owed_alone(lease))
        lost_.add({{lease.source, piece.begin, piece.end - piece.begin}, lost_with, lease.retries, 0}, now_s);
    if (const auto twin = leases_.find(lease.twin); twin != leases_.end()) twin->second.lost_with = lost_with;
    end_lease(found);
}

void Ledger::forgive(WorkerId worker, double now_s) {
    for (auto& [id, lease] : leases_) std::erase(lease.lost_with, worker);
    lost_.forgive(worker, now_s);
}

void Ledger::release_all() {
    while (!leases_.empty()) release(leases_.begin()->first);
}

void Ledger::extend(WorkerId worker, double deadline_s) {
    for (const LeaseId id : held(worker)) {
        Lease& lease = leases_.at(id);
        lease.deadline_s = std::max(lease.deadline_s, deadline_s);
    }
}

void Ledger::shorten(WorkerId worker, double deadline_s) {
    for (const LeaseId id : held(worker)) {
        Lease& lease = leases_.at(id);
        lease.deadline_s = std::min(lease.deadline_s, deadline_s);
    }
}

std::uint64_t Ledger::expire(double now_s) {
    std::vector<std::pair<LeaseId, WorkerId>> late;
    for (const auto& [id, lease] : leases_)
        if (lease.deadline_s <= now_s) late.emplace_back(id, lease.worker);
    for (const auto& [id, worker] : late) lose(id, worker, now_s);
    return late.size();
}

std::uint64_t Ledger::leased_particles() const {
    return particles_.in_all() - committed_.in_all() - unleased_ - lost_.waiting_particles() -
           lost_.set_aside_particles();
}

bool Ledger::held_by(WorkerId worker, LeaseId id) const {
    const auto found = leases_.find(id);
    return found != leases_.end() && found->second.worker == worker;
}

const std::set<LeaseId>& Ledger::held(WorkerId worker) const {
    static const std::set<LeaseId> nothing;
    const auto found = leases_by_worker_.find(worker);
    return found == leases_by_worker_.end() ? nothing : found->second;
}

std::uint64_t Ledger::owed_by(WorkerId worker) const {
    std::uint64_t particles = 0;
    for (const LeaseId id : held(worker))
        for (const Interval& piece : leases_.at(id).owed) particles += piece.end - piece.begin;
    return particles;
}

}  // namespace lumenfarm
