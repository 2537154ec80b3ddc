#include "master/audits.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace lumenfarm::testing {
namespace {

constexpr JobId job = 3;
constexpr MachineId ann = 1, bob = 2, cid = 3, dan = 4;
constexpr std::uint64_t truth = 700;
const std::array ranges{ParticleRange{0, 100, 50}, ParticleRange{1, 0, 20}};

class AuditsTest : public ::testing::Test {
protected:
    AuditsTest() { audits_.begin(job, ann, ranges, 0, 100, 9, truth); }

    /// The worker traces both ranges again, and says so in two results.
    std::optional<Audits::Finding> testify(MachineId machine, std::uint64_t fingerprint) {
        std::optional<Audits::Finding> finding;
        for (const std::uint64_t part : {fingerprint - 5, std::uint64_t{5}}) {
            EXPECT_TRUE(audits_.has_set(job, machine));
            const Audits::Set set = audits_.give(job, machine, ++leases_, 0);
            const std::array claims{Claim{leases_, set.range}};
            const auto audit = audits_.check(machine, claims);
            EXPECT_EQ(audit, set.audit);
            EXPECT_FALSE(finding);
            finding = audits_.take(*audit, claims, part);
        }
        return finding;
    }

    Audits audits_;
    LeaseId leases_ = 0;
};

TEST_F(AuditsTest, OneWhoSaysTheSameEndsIt) {
    EXPECT_FALSE(audits_.has_set(job, ann)) << "nobody audits himself";
    EXPECT_FALSE(audits_.has_set(job + 1, bob));
    const auto finding = testify(bob, truth);
    ASSERT_TRUE(finding);
    EXPECT_TRUE(finding->liars.empty());
    EXPECT_EQ(audits_.pending(job), 0u);
}

TEST_F(AuditsTest, ThirdWorkerDecides) {
    EXPECT_FALSE(testify(bob, truth + 1));
    EXPECT_EQ(audits_.disputed(job), 1u);
    EXPECT_FALSE(audits_.has_set(job, ann) || audits_.has_set(job, bob));
    EXPECT_EQ(testify(cid, truth)->liars, std::vector{bob});
}

TEST_F(AuditsTest, FirstMayBeTheLiar) {
    EXPECT_FALSE(testify(bob, truth + 1));
    EXPECT_EQ(testify(cid, truth + 1)->liars, std::vector{ann});
}

TEST_F(AuditsTest, WhereAllDifferAFourthIsAsked) {
    EXPECT_FALSE(testify(bob, truth + 1));
    EXPECT_FALSE(testify(cid, truth + 2));
    const auto finding = testify(dan, truth);
    EXPECT_EQ(finding->honest, (std::vector{ann, dan}));
    EXPECT_EQ(finding->liars, (std::vector{bob, cid}));
}

TEST_F(AuditsTest, WorkerThatIsLostIsReplacedAndItsLateResultIsNotTaken) {
    const Audits::Set set = audits_.give(job, bob, 1, 0);
    EXPECT_FALSE(audits_.has_set(job, cid)) << "one at a time";
    audits_.forget(bob, 1);
    EXPECT_FALSE(audits_.check(bob, std::array{Claim{1, set.range}}));
    leases_ = 1;
    EXPECT_TRUE(testify(cid, truth));
}

TEST_F(AuditsTest, WorkerThatTakesTooLongIsGivenUp) {
    audits_.give(job, bob, 1, 10);
    audits_.expire(110);
    EXPECT_TRUE(audits_.holds(1));
    audits_.expire(111);
    EXPECT_FALSE(audits_.holds(1));
    EXPECT_FALSE(audits_.has_set(job, bob));
    EXPECT_TRUE(audits_.has_set(job, cid));
}

TEST_F(AuditsTest, AuditThatNobodyBeginsIsDroppedUnlessTwoDiffer) {
    EXPECT_EQ(audits_.expire(100), 0u);
    EXPECT_EQ(audits_.expire(101), 1u);
    audits_.begin(job, ann, ranges, 0, 100, 9, truth);
    EXPECT_FALSE(testify(bob, truth + 1));
    EXPECT_EQ(audits_.expire(1'000), 0u);
    EXPECT_EQ(audits_.pending(job), 1u);
}

TEST_F(AuditsTest, ClaimsThatAreNotOwedAreNotTaken) {
    const Audits::Set set = audits_.give(job, bob, 1, 0);
    const auto check = [&](MachineId machine, const Claim& claim) {
        return audits_.check(machine, std::array{claim}).has_value();
    };
    EXPECT_TRUE(check(bob, {1, {0, 100, 10}}));
    EXPECT_FALSE(check(cid, {1, set.range}));
    EXPECT_FALSE(check(bob, {2, set.range}));
    EXPECT_FALSE(check(bob, {1, {1, 100, 10}}));
    EXPECT_FALSE(check(bob, {1, {0, 99, 10}}));
    EXPECT_FALSE(check(bob, {1, {0, 145, 10}}));
    EXPECT_FALSE(audits_.check(bob, std::array{Claim{1, {0, 100, 10}}, Claim{1, {0, 105, 10}}}));
    audits_.take(set.audit, std::array{Claim{1, {0, 100, 10}}}, 1);
    EXPECT_FALSE(check(bob, {1, {0, 109, 10}})) << "twice";
    EXPECT_TRUE(check(bob, {1, {0, 110, 40}}));
}

TEST_F(AuditsTest, AuditThatNobodyCanCarryOutIsDroppedUnlessTwoDiffer) {
    EXPECT_EQ(audits_.drop_hopeless(job, {ann, bob}), 0u);
    EXPECT_EQ(audits_.drop_hopeless(job, {ann}), 1u);
    EXPECT_EQ(audits_.pending(job), 0u);
    audits_.begin(job, ann, ranges, 0, 100, 9, truth);
    EXPECT_FALSE(testify(bob, truth + 1));
    EXPECT_EQ(audits_.drop_hopeless(job, {ann, bob}), 0u);
    audits_.drop(job);
    EXPECT_EQ(audits_.pending(job), 0u);
}

TEST_F(AuditsTest, WhatALiarHasSaidOfOtherParticlesNeedsNoAuditAnyMore) {
    audits_.begin(job, bob, ranges, 0, 100, 9, truth);
    audits_.distrust(ann, 0);
    EXPECT_EQ(audits_.pending(job), 1u);
    EXPECT_TRUE(testify(cid, truth));
}

TEST_F(AuditsTest, ThirdThatWasTooSlowAtFirstMayTryAgain) {
    EXPECT_FALSE(testify(bob, truth + 1));
    audits_.give(job, cid, 50, 0);
    audits_.expire(101);
    EXPECT_FALSE(audits_.has_set(job, cid));
    audits_.expire(202);
    leases_ = 60;
    EXPECT_EQ(testify(cid, truth)->liars, std::vector{bob});
}

TEST_F(AuditsTest, DisputeOutlivesWhatDropsTheOthers) {
    EXPECT_FALSE(testify(bob, truth + 1));
    audits_.begin(job, ann, ranges, 0, 100, 9, truth);
    EXPECT_EQ(audits_.drop_undisputed(job), 1u);
    EXPECT_EQ(audits_.disputed(job), 1u);
}

/// Each worker that began it was lost.
TEST_F(AuditsTest, AuditThatManyHaveBegunIsDroppedInTheEnd) {
    std::uint64_t dropped = 0;
    double now_s = 0;
    for (MachineId machine = 100; dropped == 0 && machine < 200; ++machine) {
        ASSERT_TRUE(audits_.has_set(job, machine));
        audits_.give(job, machine, ++leases_, now_s);
        EXPECT_TRUE(audits_.busy(machine));
        now_s += 90;
        audits_.forget(machine, now_s);
        EXPECT_FALSE(audits_.busy(machine));
        dropped = audits_.expire(now_s);
    }
    EXPECT_EQ(dropped, 1u);
    EXPECT_GT(now_s, 100 * limits::audit_patiences_max);
    EXPECT_EQ(audits_.pending(job), 0u);
}

TEST_F(AuditsTest, WhoWasInterruptedBeginsAnew) {
    EXPECT_FALSE(testify(bob, truth + 1));
    const Audits::Set set = audits_.give(job, cid, 50, 0);
    audits_.forget(dan, 0);
    audits_.interrupt(job, 10);
    EXPECT_FALSE(audits_.check(cid, std::array{Claim{50, set.range}}));
    leases_ = 60;
    EXPECT_EQ(testify(cid, truth)->liars, std::vector{bob});
}

}  // namespace
}  // namespace lumenfarm::testing
