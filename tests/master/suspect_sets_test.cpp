#include "tests/master/master_fixture.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

/// Sets that two workers were lost with, which only one that has nothing else in hand may get.
namespace lumenfarm::testing {
namespace {

class SuspectSets : public MasterTest {
protected:
    /// Two workers were lost with a set of job 1, and a third is there.
    void lose_twice() {
        JobSpec spec = records_job();
        spec.particles = 2'000;
        submit(spec, 1);
        join(ann, 11);
        for (WorkerId next : {12u, 13u}) {
            const auto lost = pull(ann, 1);
            ASSERT_EQ(lost.size(), 1u);
            take(master_.on_disconnect(ann, now_s_));
            now_s_ += limits::reconnect_seconds + 5;
            take(master_.tick(now_s_));
            join(ann, next);
            if (next == 12) wait_until_it_is_ready();
        }
    }
    /// To be given out again.
    void wait_until_it_is_ready() { now_s_ += 5; }
    void submit_long_job(std::int32_t priority) {
        JobSpec spec = records_job();
        spec.particles = 4'000'000;
        spec.priority = priority;
        submit(spec, 2);
    }
    std::uint64_t results_ = 0;
};

TEST_F(SuspectSets, OnlyWorkerTriesItBeforeAnotherJobOfThatPriority) {
    lose_twice();
    wait_until_it_is_ready();
    submit_long_job(0);
    auto held = pull(ann, 2);
    while (!held.empty() && held.front().job == 2) {
        ASSERT_LT(results_, 20u);
        deliver(ann, trace(held.front(), ++results_));
        held.erase(held.begin());
        for (const auto& lease : pull(ann, 2 - static_cast<std::uint32_t>(held.size()))) held.push_back(lease);
    }
    ASSERT_EQ(held.size(), 1u);
    EXPECT_EQ(held.front().job, 1u);
}

TEST_F(SuspectSets, GoBeforeAuditsToWhoHasEmptyHands) {
    MasterPolicy audits = policy();
    audits.audit_fraction = 1;
    master_ = MasterCore(audits);
    lose_twice();
    join(bob, 20);
    const auto other = pull(bob, 1);
    ASSERT_EQ(other.size(), 1u);
    pull(bob, 0);
    wait_until_it_is_ready();
    deliver(bob, trace(other.front(), ++results_));
    const auto suspect = pull(ann, 1);
    ASSERT_EQ(suspect.size(), 1u);
    EXPECT_EQ(suspect.front().audit, 0u);
    EXPECT_TRUE(pull(ann, 4).empty()) << "not even audits come beside it";
    pull(ann, 0);
    deliver(ann, trace(suspect.front(), ++results_));
    const auto audit = pull(ann, 1);
    ASSERT_EQ(audit.size(), 1u);
    EXPECT_NE(audit.front().audit, 0u);
}

TEST_F(SuspectSets, NobodyIsKeptFreeWhileAMoreUrgentJobHasSets) {
    lose_twice();
    wait_until_it_is_ready();
    submit_long_job(5);
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(pull(ann, 2).size(), 2u) << i;
        now_s_ += 1;
    }
}

TEST_F(SuspectSets, AreTriedThoughOtherJobsKeepEverybodyBusy) {
    lose_twice();
    wait_until_it_is_ready();
    submit_long_job(-1);
    join(bob, 20);
    // both have a backlog that is filled again at once, until one of them is to have its hands free
    std::map<SessionId, std::vector<wire::Lease>> held;
    for (const SessionId worker : {ann, bob}) held[worker] = pull(worker, 2);
    bool tried = false;
    for (int i = 0; i < 40 && !tried; ++i)
        for (const SessionId worker : {ann, bob}) {
            if (held[worker].empty()) {
                held[worker] = pull(worker, 2);
            } else {
                deliver(worker, trace(held[worker].back(), ++results_));
                held[worker].pop_back();
                for (const auto& lease : all_sent<wire::Lease>(worker)) held[worker].push_back(lease);
                for (const auto& lease : pull(worker, 1)) held[worker].push_back(lease);
            }
            for (const auto& lease : held[worker]) tried |= lease.job == 1 && held[worker].size() == 1;
            now_s_ += 1;
        }
    EXPECT_TRUE(tried);
}

}  // namespace
}  // namespace lumenfarm::testing
