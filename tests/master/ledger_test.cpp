#include "master/ledger.h"

#include <gtest/gtest.h>

#include <array>

namespace lumenfarm {
namespace {

constexpr WorkerId ann = 1, bob = 2;

Claim whole(LeaseId lease, const ParticleRange& range) { return {lease, range}; }

ClaimVerdict verdict(const Ledger& ledger, WorkerId worker, const Claim& claim) {
    return ledger.check(worker, std::array{claim});
}

void commit(Ledger& ledger, std::span<const Claim> claims) {
    ledger.store(claims);
    ledger.commit(claims);
}

/// To a worker that has nothing in hand.
std::optional<ParticleRange> lease(Ledger& ledger, LeaseId id, WorkerId worker, std::uint64_t count, double now_s,
                                   double deadline_s) {
    const auto given = ledger.lease(id, worker, Ledger::Hands::empty, count, now_s, deadline_s);
    return given ? std::optional(given->range) : std::nullopt;
}

TEST(Ledger, GivesEveryParticleOnce) {
    Ledger ledger({1'000, 10});
    IntervalSet seen[2];
    for (LeaseId id = 1; const auto range = lease(ledger, id, ann, 7, 0, 60); ++id)
        EXPECT_TRUE(seen[range->source].insert(range->first, range->first + range->count));
    EXPECT_TRUE(seen[0].covers(0, 1'000));
    EXPECT_TRUE(seen[1].covers(0, 10));
    EXPECT_EQ(ledger.unleased(), 0u);
}

TEST(Ledger, GivesTheLightsEqualFractions) {
    Ledger ledger({10'000, 1'000});
    std::uint64_t given[2] = {0, 0};
    for (LeaseId id = 1; id <= 50; ++id) {
        const auto range = lease(ledger, id, ann, 100, 0, 60);
        given[range->source] += range->count;
    }
    EXPECT_NEAR(static_cast<double>(given[0]) / 10'000, static_cast<double>(given[1]) / 1'000, 0.1);
}

TEST(Ledger, GivesNothingOfALightWithoutParticles) {
    Ledger ledger({0, 5});
    EXPECT_EQ(lease(ledger, 1, ann, 100, 0, 60), (ParticleRange{1, 0, 5}));
    EXPECT_FALSE(lease(ledger, 2, ann, 100, 0, 60));
}

TEST(Ledger, RangeCommittedTwiceIsMergedOnce) {
    Ledger ledger({100});
    const auto range = lease(ledger, 1, ann, 100, 0, 60);
    const Claim claim = whole(1, *range);
    ASSERT_EQ(verdict(ledger, ann, claim), ClaimVerdict::current);
    commit(ledger, std::array{claim});
    EXPECT_EQ(verdict(ledger, ann, claim), ClaimVerdict::already_committed);
    EXPECT_EQ(ledger.committed_particles(), 100u);
    EXPECT_TRUE(ledger.complete());
}

TEST(Ledger, PartOfALeaseIsCommittedAndTheRestIsStillOwed) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 100, 0, 60);
    commit(ledger, std::array{Claim{1, {0, 0, 40}}});
    EXPECT_TRUE(ledger.holds(1));
    EXPECT_EQ(verdict(ledger, ann, {1, {0, 30, 20}}), ClaimVerdict::already_committed);
    EXPECT_EQ(verdict(ledger, ann, {1, {0, 40, 60}}), ClaimVerdict::current);
    ledger.release(1);
    EXPECT_EQ(ledger.unleased(), 60u);
    EXPECT_EQ(lease(ledger, 2, bob, 1'000, 0, 60), (ParticleRange{0, 40, 60}));
}

TEST(Ledger, ExpiredLeaseIsStaleAndGivenToAnother) {
    Ledger ledger({100});
    const auto range = lease(ledger, 1, ann, 100, 0, 60);
    EXPECT_EQ(ledger.expire(59), 0u);
    EXPECT_EQ(ledger.expire(60), 1u);
    EXPECT_EQ(verdict(ledger, ann, whole(1, *range)), ClaimVerdict::stale);
    EXPECT_FALSE(lease(ledger, 2, bob, 100, 60, 120)) << "a lost set waits a moment";
    EXPECT_EQ(lease(ledger, 2, bob, 100, 60 + limits::retry_seconds, 120), range);
    EXPECT_EQ(verdict(ledger, ann, whole(1, *range)), ClaimVerdict::stale);
    EXPECT_EQ(verdict(ledger, bob, whole(2, *range)), ClaimVerdict::current);
}

TEST(Ledger, HeartbeatKeepsALease) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 50, 0, 60);
    lease(ledger, 2, bob, 50, 0, 60);
    ledger.extend(ann, 100);
    EXPECT_EQ(ledger.expire(70), 1u);
    EXPECT_TRUE(ledger.holds(1));
    EXPECT_FALSE(ledger.holds(2));
}

TEST(Ledger, LostWorkerKeepsItsLeasesForTheGraceOnly) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 50, 0, 60);
    ledger.shorten(ann, 10);
    EXPECT_EQ(ledger.expire(9), 0u);
    EXPECT_EQ(ledger.expire(10), 1u);
}

TEST(Ledger, OnlyTheHolderOfALeaseMayClaimIt) {
    Ledger ledger({100});
    const auto range = lease(ledger, 1, ann, 100, 0, 60);
    EXPECT_EQ(verdict(ledger, bob, whole(1, *range)), ClaimVerdict::stale);
}

TEST(Ledger, ClaimsOutsideTheLeaseAreInvalid) {
    Ledger ledger({100, 100});
    lease(ledger, 1, ann, 50, 0, 60);  // light 0, [0, 50)
    for (const ParticleRange& range : {ParticleRange{0, 0, 51},
                                       {0, 49, 2},
                                       {0, 60, 1},
                                       {1, 0, 50},
                                       {2, 0, 1},
                                       {0, 0, 0},
                                       {0, ~0ull, 2},
                                       {0, 1, ~0ull}})
        EXPECT_EQ(verdict(ledger, ann, {1, range}), ClaimVerdict::invalid) << range.first << " " << range.count;
    EXPECT_EQ(ledger.check(ann, {}), ClaimVerdict::invalid);
}

TEST(Ledger, OneResultMayNotClaimAParticleTwice) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 100, 0, 60);
    EXPECT_EQ(ledger.check(ann, std::array{Claim{1, {0, 0, 60}}, Claim{1, {0, 59, 10}}}), ClaimVerdict::invalid);
    EXPECT_EQ(ledger.check(ann, std::array{Claim{1, {0, 60, 10}}, Claim{1, {0, 0, 60}}}), ClaimVerdict::current);
}

TEST(Ledger, FirstOfTwoTwinsWins) {
    Ledger ledger({100});
    const auto range = lease(ledger, 1, ann, 100, 0, 60);
    EXPECT_FALSE(ledger.lease_twin(2, ann, 100, 5, 60)) << "not to the straggler itself";
    EXPECT_FALSE(ledger.lease_twin(2, bob, 0, 5, 60)) << "not before it is late";
    ASSERT_EQ(ledger.lease_twin(2, bob, 5, 5, 60)->range, range);
    EXPECT_FALSE(ledger.lease_twin(3, bob, 100, 5, 60)) << "one twin is enough";
    commit(ledger, std::array{whole(2, *range)});
    EXPECT_TRUE(ledger.complete());
    EXPECT_EQ(ledger.outstanding(), 0u);
    EXPECT_EQ(verdict(ledger, ann, whole(1, *range)), ClaimVerdict::already_committed);
}

TEST(Ledger, TheLeaseThatIsMostOverdueGetsATwin) {
    Ledger ledger({300});
    lease(ledger, 1, ann, 100, 0, 60);
    ASSERT_TRUE(ledger.lease(2, ann, Ledger::Hands::full, 100, 0, 60, {}, 20));
    ASSERT_TRUE(ledger.lease(3, ann, Ledger::Hands::full, 100, 0, 60, {}, 10));
    EXPECT_EQ(ledger.owed_by(ann), 300u);
    EXPECT_EQ(ledger.owed_by(bob), 0u);
    EXPECT_EQ(ledger.lease_twin(4, bob, 15, 25, 60)->range, (ParticleRange{0, 0, 100}));
    EXPECT_EQ(ledger.lease_twin(5, bob, 15, 25, 60)->range, (ParticleRange{0, 200, 100}));
    EXPECT_FALSE(ledger.lease_twin(6, bob, 15, 25, 60)) << "the other one is not due yet";
}

TEST(Ledger, TwinOwesOnlyWhatTheStragglerOwes) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 100, 0, 60);
    commit(ledger, std::array{Claim{1, {0, 0, 30}}});
    EXPECT_EQ(ledger.lease_twin(2, bob, 5, 5, 60)->range, (ParticleRange{0, 30, 70}));
    commit(ledger, std::array{Claim{1, {0, 30, 10}}});
    EXPECT_EQ(verdict(ledger, bob, {2, {0, 30, 70}}), ClaimVerdict::already_committed);
    EXPECT_EQ(verdict(ledger, bob, {2, {0, 40, 60}}), ClaimVerdict::current);
}

TEST(Ledger, ReleasedTwinGivesNothingBackTwice) {
    for (const LeaseId first : {1u, 2u}) {
        Ledger ledger({100});
        lease(ledger, 1, ann, 100, 0, 60);
        ledger.lease_twin(2, bob, 5, 5, 60);
        ledger.release(first);
        EXPECT_EQ(ledger.unleased(), 0u);
        ledger.release(3 - first);
        EXPECT_EQ(ledger.unleased(), 100u);
    }
}

TEST(Ledger, ReleaseOfAllLeavesNothingLeased) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 20, 0, 60);
    lease(ledger, 2, bob, 20, 0, 60);
    EXPECT_EQ(ledger.leased_particles(), 40u);
    ledger.release_all();
    EXPECT_EQ(ledger.outstanding(), 0u);
    EXPECT_EQ(ledger.leased_particles(), 0u);
    EXPECT_EQ(ledger.unleased(), 100u);
}

TEST(Ledger, SetLostTwiceGoesToAWorkerWithEmptyHandsAndAloneAndIsSetAsideAfterTheThirdLoss) {
    Ledger ledger({100});
    double now_s = 0;
    const auto lost = lease(ledger, 1, ann, 10, now_s, 60);
    now_s = 60;
    ledger.expire(now_s);
    EXPECT_EQ(ledger.leased_particles(), 0u);
    EXPECT_EQ(ledger.unleased(), 90u);
    now_s += limits::retry_seconds;
    const auto again = ledger.lease(2, bob, Ledger::Hands::full, 10, now_s, now_s + 60);
    EXPECT_EQ(again->range, lost);
    EXPECT_FALSE(again->alone);
    now_s += 60;
    ledger.expire(now_s);
    EXPECT_NE(ledger.lease(3, ann, Ledger::Hands::empty, 10, now_s + 1.9 * limits::retry_seconds, 1e9)->range, lost)
        << "the wait doubles";
    now_s += 2 * limits::retry_seconds;
    EXPECT_NE(ledger.lease(4, ann, Ledger::Hands::full, 10, now_s, 1e9)->range, lost);
    const auto alone = ledger.lease(5, bob, Ledger::Hands::empty, 10, now_s, now_s + 60);
    EXPECT_EQ(alone->range, lost);
    EXPECT_TRUE(alone->alone);
    ledger.expire(now_s + 60);
    ASSERT_EQ(ledger.lost().set_aside().size(), 1u);
    EXPECT_EQ(ledger.lost().set_aside()[0].range, *lost);
    EXPECT_FALSE(ledger.only_set_aside_left());
    for (LeaseId id = 6; const auto rest = lease(ledger, id, bob, 100, 1e6, 1e9); ++id)
        EXPECT_NE(rest->first, lost->first);
    for (const WorkerId worker : {ann, bob})
        for (const LeaseId id : ledger.leases_of(worker)) {
            const std::array done{Claim{id, id == 3   ? ParticleRange{0, 10, 10}
                                            : id == 4 ? ParticleRange{0, 20, 10}
                                                      : ParticleRange{0, 30, 70}}};
            ledger.store(done);
            ledger.commit(done);
        }
    EXPECT_TRUE(ledger.only_set_aside_left());
    EXPECT_FALSE(ledger.complete());
}

TEST(Ledger, WorkerThatComesBackWasNotKilled) {
    Ledger ledger({100});
    double now_s = 0;
    for (const WorkerId worker : {ann, bob, WorkerId{77}}) {
        const auto given = ledger.lease(worker, worker, Ledger::Hands::empty, 100, now_s, now_s + 60);
        ASSERT_TRUE(given);
        ledger.expire(now_s += 60);
        now_s += 10;
    }
    EXPECT_TRUE(ledger.only_set_aside_left());
    ledger.forgive(bob, now_s);
    EXPECT_TRUE(ledger.lost().set_aside().empty());
    const auto again = ledger.lease(99, bob, Ledger::Hands::empty, 100, now_s + 10, 1e9);
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->alone);
    ledger.forgive(ann, now_s);
    ledger.expire(2e9);
    EXPECT_TRUE(ledger.lost().set_aside().empty()) << "two are left: the last one, and the one that never came back";
}

TEST(Ledger, WhatWasSetAsideIsTriedTwiceMoreWhenNothingElseIsLeft) {
    Ledger ledger({100});
    double now_s = 0;
    LeaseId id = 0;
    const auto lose = [&] {
        ++id;
        const auto given = ledger.lease(id, id, Ledger::Hands::empty, 100, now_s, now_s + 60);
        if (given) ledger.expire(now_s += 60);
        return given.has_value();
    };
    for (; !ledger.only_set_aside_left(); now_s += 10) ASSERT_TRUE(lose());
    for (std::uint32_t again = 0; again < limits::set_aside_retries; ++again) {
        ASSERT_TRUE(ledger.retry_set_aside(now_s));
        EXPECT_FALSE(lose()) << "it waits";
        now_s += again == 0 ? limits::set_aside_seconds : 4 * limits::set_aside_seconds;
        ASSERT_TRUE(lose());
        EXPECT_TRUE(ledger.only_set_aside_left()) << "one loss is enough now";
    }
    EXPECT_FALSE(ledger.retry_set_aside(now_s));
}

TEST(Ledger, SetThatWasTracedAfterALossIsForgiven) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 100, 0, 60);
    ledger.expire(60);
    const auto range = lease(ledger, 2, bob, 100, 100, 160);
    const std::array done{Claim{2, *range}};
    ledger.store(done);
    ledger.commit(done);
    EXPECT_TRUE(ledger.complete());
    EXPECT_EQ(ledger.lost().waiting_particles(), 0u);
}

TEST(Ledger, ParticlesOnTheirWayToTheDiskAreNeitherGivenNorCommitted) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 100, 0, 60);
    const std::array stored{Claim{1, {0, 0, 60}}};
    ledger.store(stored);
    EXPECT_EQ(ledger.committed_particles(), 0u);
    EXPECT_EQ(verdict(ledger, ann, {1, {0, 50, 10}}), ClaimVerdict::being_stored);
    EXPECT_EQ(verdict(ledger, bob, {1, {0, 50, 10}}), ClaimVerdict::being_stored);
    ledger.release(1);
    EXPECT_EQ(ledger.unleased(), 40u);
    EXPECT_EQ(lease(ledger, 2, bob, 100, 0, 60), (ParticleRange{0, 60, 40}));
    ledger.commit(stored);
    EXPECT_EQ(ledger.committed_particles(), 60u);
    EXPECT_EQ(verdict(ledger, ann, {1, {0, 50, 10}}), ClaimVerdict::already_committed);
}

TEST(Ledger, ALeaseThatIsStoredWholeEndsAndSaysSo) {
    Ledger ledger({100});
    lease(ledger, 1, ann, 50, 0, 60);
    lease(ledger, 2, ann, 50, 0, 60);
    EXPECT_TRUE(ledger.take_ended().empty());
    ledger.store(std::array{Claim{1, {0, 0, 50}}});
    EXPECT_FALSE(ledger.holds(1));
    ledger.release(2);
    EXPECT_EQ(ledger.take_ended(), (std::vector<LeaseId>{1, 2}));
    EXPECT_TRUE(ledger.take_ended().empty());
}

TEST(Ledger, GoesOnWhereAnEarlierOneEnded) {
    std::vector<IntervalSet> committed(2);
    ASSERT_TRUE(committed[0].insert(10, 20));
    ASSERT_TRUE(committed[0].insert(40, 50));
    const std::array leases{GivenLease{7, ann, {0, 0, 30}}, GivenLease{8, bob, {0, 40, 10}},
                            GivenLease{9, bob, {0, 25, 10}}, GivenLease{6, bob, {1, 95, 6}}};
    Ledger ledger({60, 100}, 2, committed, leases, 5, 50);
    EXPECT_EQ(ledger.committed_particles(), 20u);
    EXPECT_TRUE(ledger.held_by(ann, 7));
    EXPECT_EQ(verdict(ledger, ann, {7, {0, 0, 10}}), ClaimVerdict::current);
    EXPECT_EQ(verdict(ledger, ann, {7, {0, 10, 10}}), ClaimVerdict::already_committed);
    EXPECT_FALSE(ledger.holds(8)) << "all of it was committed";
    EXPECT_FALSE(ledger.holds(9)) << "ann has a part of it";
    EXPECT_FALSE(ledger.holds(6)) << "the light has 100 particles";
    EXPECT_EQ(ledger.take_ended(), (std::vector<LeaseId>{8, 9, 6}));
    EXPECT_EQ(ledger.unleased(), 20u + 100u);
    IntervalSet given;
    for (LeaseId id = 100; const auto range = lease(ledger, id, bob, 7, 5, 50); ++id)
        if (range->source == 0) {
            EXPECT_TRUE(given.insert(range->first, range->first + range->count));
        }
    EXPECT_EQ(given.intervals(), (std::vector<IntervalSet::Interval>{{30, 40}, {50, 60}}));
    EXPECT_EQ(ledger.expire(51), 1u + 4u + 15u);
}

/// One light of 100 particles, and queues of 0 to 2.
class QueueLedger : public ::testing::Test {
protected:
    std::optional<ParticleRange> lease_of(LeaseId id, std::uint32_t source, std::uint64_t count = 1'000) {
        const auto given = ledger_.lease(id, ann, Ledger::Hands::empty, count, 0, 60, source);
        return given ? std::optional(given->range) : std::nullopt;
    }
    void finish(LeaseId id, const ParticleRange& range) { commit(ledger_, std::array{whole(id, range)}); }

    Ledger ledger_{{100, 0, 0, 0}, 1, {}, {}, 0, 0};
};

TEST_F(QueueLedger, QueueGivesWhatWasFiled) {
    EXPECT_FALSE(lease_of(1, 2));
    ledger_.grow(2, 10);
    ledger_.grow(3, 4);
    ledger_.grow(2, 5);
    EXPECT_EQ(ledger_.queued(), 19u);
    EXPECT_EQ(*ledger_.queues().rbegin(), (std::pair<std::uint64_t, std::uint32_t>{15, 2}));
    EXPECT_EQ(lease_of(1, 2, 12), (ParticleRange{2, 0, 12}));
    EXPECT_EQ(lease_of(2, 2), (ParticleRange{2, 12, 3}));
    EXPECT_FALSE(lease_of(3, 2));
    EXPECT_EQ(ledger_.queued(), 4u);
    EXPECT_EQ(ledger_.contradiction(), std::nullopt);
}

TEST_F(QueueLedger, IsCompleteWhenNothingIsInFlight) {
    finish(1, *lease_of(1, 0));
    EXPECT_EQ(ledger_.committed_particles(), 100u);
    EXPECT_TRUE(ledger_.complete());
    ledger_.grow(1, 3);
    EXPECT_FALSE(ledger_.complete());
    finish(2, *lease_of(2, 1));
    EXPECT_TRUE(ledger_.complete());
    EXPECT_EQ(ledger_.particles(), 100u);
    EXPECT_EQ(ledger_.committed_particles(), 100u) << "flights are no particles of their own";
}

TEST_F(QueueLedger, WhatALostWorkerHadOfAQueueIsGivenOutAgain) {
    ledger_.grow(1, 10);
    const auto range = lease_of(1, 1);
    ledger_.release(1);
    EXPECT_EQ(lease_of(2, 1), range);
    EXPECT_EQ(verdict(ledger_, ann, whole(1, *range)), ClaimVerdict::stale);
    EXPECT_EQ(ledger_.expire(61), 1u);
    EXPECT_EQ(ledger_.queued(), 0u);
    const auto given = ledger_.lease(3, bob, Ledger::Hands::empty, 1'000, 100, 160);
    ASSERT_TRUE(given);
    EXPECT_EQ(given->range, *range);
    EXPECT_EQ(ledger_.contradiction(), std::nullopt);
}

TEST_F(QueueLedger, RestartEmptiesTheQueues) {
    ledger_.grow(1, 10);
    ledger_.grow(2, 10);
    finish(1, *lease_of(1, 0, 40));
    (void)lease_of(2, 1, 4);
    (void)ledger_.take_ended();
    ledger_.restart();
    EXPECT_EQ(ledger_.take_ended(), std::vector<LeaseId>{2});
    EXPECT_EQ(ledger_.unleased(), 100u);
    EXPECT_EQ(ledger_.queued(), 0u);
    EXPECT_EQ(ledger_.committed_particles(), 0u);
    EXPECT_FALSE(ledger_.holds(2));
    EXPECT_EQ(ledger_.contradiction(), std::nullopt);
}

TEST(Ledger, QueuesGoOnWhereAnEarlierOneEnded) {
    std::vector<IntervalSet> committed(2);
    ASSERT_TRUE(committed[0].insert(0, 50));
    ASSERT_TRUE(committed[1].insert(0, 10));
    const std::array leases{GivenLease{7, ann, {1, 5, 10}}, GivenLease{8, ann, {1, 15, 10}}};
    Ledger ledger({50, 20}, 1, committed, leases, 5, 50);
    EXPECT_EQ(verdict(ledger, ann, {7, {1, 10, 5}}), ClaimVerdict::current);
    EXPECT_FALSE(ledger.holds(8)) << "so many were never filed";
    EXPECT_EQ(ledger.queued(), 5u);
    EXPECT_FALSE(ledger.complete());
}

/// A relay's: of one light and one queue, and nothing is lent.
Ledger nothing_lent(std::uint64_t particles) {
    std::vector<IntervalSet> committed(2);
    committed[0].insert(0, particles);
    return Ledger({particles, 0}, 1, std::move(committed), {}, 0, 0);
}

TEST(Ledger, WhatIsNotLentIsNotGiven) {
    Ledger ledger = nothing_lent(1'000);
    EXPECT_EQ(ledger.lent(), 0u);
    EXPECT_FALSE(lease(ledger, 1, ann, 100, 0, 60));
    ledger.lend({0, 300, 100});
    EXPECT_EQ(ledger.lent(), 100u);
    EXPECT_FALSE(ledger.may_lend({0, 350, 100}));
    EXPECT_EQ(lease(ledger, 1, ann, 1'000, 0, 60), (ParticleRange{0, 300, 100}));
    EXPECT_FALSE(lease(ledger, 2, ann, 100, 0, 60));
    const std::array claims{whole(1, {0, 300, 100})};
    ASSERT_EQ(ledger.check(ann, claims), ClaimVerdict::current);
    commit(ledger, claims);
    EXPECT_EQ(ledger.lent(), 0u);
    EXPECT_TRUE(ledger.may_lend({0, 300, 100})) << "the master above may want them again";
    EXPECT_EQ(ledger.contradiction(), std::nullopt);
}

TEST(Ledger, LentFlightsMayLieAnywhere) {
    Ledger ledger = nothing_lent(10);
    ledger.lend({1, 500, 20});
    ledger.lend({1, 100, 10});
    EXPECT_FALSE(ledger.may_lend({1, 90, 20}));
    EXPECT_TRUE(ledger.may_lend({1, 520, 5}));
    std::uint64_t given = 0;
    for (LeaseId id = 1; id < 9; ++id)
        if (const auto next = ledger.lease(id, ann, Ledger::Hands::empty, 100, 0, 60, 1)) given += next->range.count;
    EXPECT_EQ(given, 30u);
    EXPECT_EQ(ledger.contradiction(), std::nullopt);
}

TEST(Ledger, WithdrawnParticlesAreNobodys) {
    Ledger ledger = nothing_lent(1'000);
    ledger.lend({0, 0, 400});
    ASSERT_EQ(lease(ledger, 1, ann, 100, 0, 60), (ParticleRange{0, 0, 100}));
    ASSERT_EQ(lease(ledger, 2, bob, 100, 0, 10), (ParticleRange{0, 100, 100}));
    ledger.expire(20);  // bob's are lost
    const std::array first_half{whole(1, {0, 0, 50})};
    ledger.store(first_half);
    const auto withdrawn = ledger.withdraw({0, 0, 300});
    EXPECT_EQ(withdrawn, (std::vector<IntervalSet::Interval>{{50, 300}})) << "what has arrived is not taken away";
    EXPECT_FALSE(ledger.holds(1));
    EXPECT_EQ(verdict(ledger, ann, whole(1, {0, 50, 50})), ClaimVerdict::already_committed);
    ledger.commit(first_half);
    EXPECT_EQ(ledger.lent(), 100u);
    EXPECT_EQ(lease(ledger, 3, ann, 1'000, 1'000, 2'000), (ParticleRange{0, 300, 100}));
    EXPECT_FALSE(lease(ledger, 4, ann, 1'000, 1'000, 2'000));
    EXPECT_EQ(ledger.contradiction(), std::nullopt);
}

TEST(Ledger, LentTwiceAWithdrawnLeaseStaysStale) {
    Ledger ledger = nothing_lent(100);
    ledger.lend({0, 0, 100});
    ASSERT_TRUE(lease(ledger, 1, ann, 100, 0, 60));
    ledger.withdraw({0, 0, 100});
    ledger.lend({0, 0, 100});
    EXPECT_EQ(verdict(ledger, ann, whole(1, {0, 0, 100})), ClaimVerdict::stale);
    EXPECT_TRUE(lease(ledger, 2, bob, 100, 0, 60));
    EXPECT_EQ(ledger.contradiction(), std::nullopt);
}

TEST(Ledger, WithdrawnTwinsBothEnd) {
    Ledger ledger = nothing_lent(100);
    ledger.lend({0, 0, 100});
    ASSERT_TRUE(lease(ledger, 1, ann, 100, 0, 60));
    ASSERT_TRUE(ledger.lease_twin(2, bob, 1, 2, 60));
    ledger.withdraw({0, 0, 100});
    EXPECT_EQ(ledger.outstanding(), 0u);
    EXPECT_EQ(ledger.contradiction(), std::nullopt);
}

}  // namespace
}  // namespace lumenfarm
