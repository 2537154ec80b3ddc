#include "tests/master/master_fixture.h"

#include <gtest/gtest.h>

#include <utility>

/// Results that are traced again, and what becomes of workers that lied.
namespace lumenfarm::testing {
namespace {

class AuditedMasterTest : public MasterTest {
protected:
    static constexpr SessionId cid = 3;

    AuditedMasterTest() {
        MasterPolicy policy = MasterTest::policy();
        policy.audit_fraction = 1;
        policy.audit_key = 5;
        master_ = MasterCore(policy);
    }
    /// Balanced, and not what the tracer says.
    std::pair<wire::ResultHits, wire::ResultDone> lie(const wire::Lease& lease, std::uint64_t number) {
        auto result = trace(lease, number);
        result.first.records.at(7).direction_u ^= 1;
        return result;
    }
    /// The worker pulls and traces until nothing is left for it.
    void work(SessionId session, bool honestly = true) {
        for (auto leases = pull(session, 1); !leases.empty(); leases = pull(session, 1)) {
            const auto result = honestly ? trace(leases[0], ++results_) : lie(leases[0], ++results_);
            take(master_.on_message(session, result.first, 0, now_s_));
            take(master_.on_message(session, result.second, 0, now_s_), true);
            if (find<Retract>()) return;
        }
        pull(session, 0);
    }
    /// Two honest machines trace again what there is.
    void contradict() {
        join(bob, 12);
        work(bob);
        join(cid, 13);
        work(cid);
    }
    std::uint64_t results_ = 0;
};

/// They reach the worker as others do.
TEST_F(AuditedMasterTest, LeasesOfAuditsOnTheirWayCountForAPull) {
    submit(records_job(), 1);
    join(ann, 11);
    join(bob, 12);
    work(ann);
    ASSERT_EQ(pull(bob, 3).size(), 3u);
    take(master_.on_message(bob, wire::Pull(4, 0), 0, now_s_));
    EXPECT_EQ(all_sent<wire::Lease>(bob).size(), 1u);
}

TEST_F(AuditedMasterTest, JobEndsWhenEveryAuditHas) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    join(bob, 12);
    work(ann);
    EXPECT_EQ(master_.status(job, now_s_)->committed, 10'000u);
    EXPECT_FALSE(solution_);
    EXPECT_EQ(master_.status(job, now_s_)->sentence, "job 1 waits for 11 audits to end");
    work(bob);
    ASSERT_TRUE(solution_);
    EXPECT_EQ(solution_->record.status.audits, 11u);
    EXPECT_EQ(solution_->record.status.liars, 0u);
    EXPECT_TRUE(master_.record(job)->audited);
}

TEST_F(AuditedMasterTest, FarmOfOneWorkerEndsWithoutAudits) {
    submit(records_job(), 1);
    join(ann, 11);
    work(ann);
    take(master_.tick(now_s_));
    EXPECT_TRUE(solution_);
    EXPECT_EQ(master_.discarded(Discard::audit_hopeless), 11u);
}

TEST_F(AuditedMasterTest, LiarIsKeptOutAndAllThatItCommittedIsTracedAgain) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    for (int i = 0; i < 4; ++i) deliver(ann, lie(pull(ann, 1).at(0), ++results_));
    join(bob, 12);
    work(bob);
    // only the third can say who of the two it was
    EXPECT_FALSE(find<Retract>());
    EXPECT_NE(master_.status(job, now_s_)->sentence.find("contradict each other"), std::string::npos);
    join(cid, 13);
    work(cid);
    const auto retract = find<Retract>();
    ASSERT_TRUE(retract);
    EXPECT_EQ(retract->machines.size(), 1u);
    EXPECT_FALSE(retract->all);
    EXPECT_EQ(sent<wire::Goodbye>(ann)->reason, wire::GoodbyeReason::refused);
    EXPECT_TRUE(pull(bob, 1).empty()) << "before it is known what is left";
    pull(bob, 0);

    Retracted left;
    left.committed.resize(2);
    left.committed[0].insert(0, prepared_->particles[0]);
    const std::uint64_t before = master_.status(job, now_s_)->committed;
    EXPECT_EQ(before, 10'000u);
    left.balance.particles = left.committed[0].size();
    left.keep_threshold = 100;
    take(master_.on_retracted(*retract, std::move(left), now_s_));
    EXPECT_EQ(master_.status(job, now_s_)->committed, prepared_->particles[0]);
    EXPECT_EQ(master_.status(job, now_s_)->liars, 1u);
    for (int rounds = 0; rounds < 3; ++rounds) {
        work(bob);
        work(cid);
    }
    ASSERT_TRUE(solution_);
    EXPECT_TRUE(solution_->record.complete);

    greet(ann, 11);
    EXPECT_EQ(sent<wire::Goodbye>(ann)->reason, wire::GoodbyeReason::refused);
    EXPECT_GE(master_.discarded(Discard::quarantined), 2u);
}

TEST_F(AuditedMasterTest, WhoSendsImpossibleResultsHasItsOthersTracedAgain) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    deliver(ann, trace(pull(ann, 1).at(0), ++results_));
    EXPECT_EQ(master_.status(job, now_s_)->committed, 1'000u);
    for (std::uint32_t i = 0; i < limits::invalid_results_max; ++i) {
        EXPECT_FALSE(find<Retract>());
        auto impossible = trace(pull(ann, 1).at(0), ++results_);
        impossible.second.balance.escaped += 1;
        deliver(ann, impossible);
    }
    ASSERT_TRUE(find<Retract>());
    EXPECT_EQ(find<Retract>()->machines.size(), 1u);
    EXPECT_EQ(master_.status(job, now_s_)->liars, 1u);
    EXPECT_EQ(master_.discarded(Discard::lied), 1u);
}

TEST_F(AuditedMasterTest, NextLifeTakesOutWhatALiarHasTraced) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    deliver(ann, lie(pull(ann, 1).at(0), ++results_));
    contradict();
    ASSERT_TRUE(find<Retract>());
    const JobRecord kept = *master_.record(job);
    EXPECT_EQ(kept.liars.size(), 1u);
    EXPECT_TRUE(find<Retract>()->record.liars.empty());

    master_ = MasterCore(policy());
    master_.restore(kept);
    take(master_.tick(now_s_));
    prepare({});
    const auto retract = find<Retract>();
    ASSERT_TRUE(retract);
    EXPECT_EQ(retract->machines.size(), 1u);
    join(bob, 12);
    EXPECT_TRUE(pull(bob, 1).empty());
    Retracted left;
    left.committed.resize(2);
    take(master_.on_retracted(*retract, std::move(left), now_s_));
    EXPECT_TRUE(master_.record(job)->liars.empty());
    EXPECT_EQ(all_sent<wire::Lease>(bob).size(), 1u);
}

TEST_F(AuditedMasterTest, DisputeOutlivesAPauseAndHoldsNothingUp) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    deliver(ann, lie(pull(ann, 1).at(0), ++results_));
    join(bob, 12);
    work(bob);
    work(ann);
    take(master_.on_message(embedding_session, wire::ControlRequest(job, wire::JobAction::pause), 8, now_s_));
    EXPECT_FALSE(solution_) << "all is committed, and not all is true";
    const auto aside = find<PutAside>();
    ASSERT_TRUE(aside);
    take(master_.on_put_aside(*aside, now_s_));
    join(cid, 13);
    EXPECT_TRUE(pull(cid, 1).empty());
    pull(cid, 0);
    take(master_.on_message(embedding_session, wire::ControlRequest(job, wire::JobAction::resume), 9, now_s_));
    RecoveredJob all;
    for (const std::uint64_t particles : prepared_->particles) all.committed.emplace_back().insert(0, particles);
    prepare(std::move(all));
    EXPECT_FALSE(solution_);
    work(cid);
    EXPECT_TRUE(find<Retract>());
}

/// Its kept hits were chosen with a threshold that the lies had lowered.
TEST_F(AuditedMasterTest, LeasesOfADistrustedJobDoNotComeBack) {
    JobSpec spec = records_job();
    spec.keep_hits = 10;
    const JobId job = submit(spec, 1);
    join(ann, 11);
    const auto lease = pull(ann, 1).at(0);
    JobRecord kept = *master_.record(job);
    kept.distrusted = true;
    kept.liars = {77};
    master_ = MasterCore(policy());
    master_.restore(kept);
    take(master_.tick(now_s_));
    RecoveredJob recovered;
    recovered.leases = {{lease.lease, 11, lease.range}};
    prepare(std::move(recovered));
    EXPECT_EQ(master_.status(job, now_s_)->leased, 0u);
    const auto ended = find<StoreLeases>();
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->ended, std::vector{lease.lease}) << "nor in the next life";
}

TEST_F(AuditedMasterTest, JobThatWaitsLosesWhatALiarHasTracedOfIt) {
    const JobId first = submit(records_job(), 1);
    join(ann, 11);
    deliver(ann, lie(pull(ann, 1).at(0), ++results_));
    take(master_.on_message(embedding_session, wire::ControlRequest(first, wire::JobAction::pause), 8, now_s_));
    const auto aside = find<PutAside>();
    ASSERT_TRUE(aside);
    take(master_.on_put_aside(*aside, now_s_));
    const JobId second = submit(records_job(), 2);
    deliver(ann, lie(pull(ann, 1).at(0), ++results_));
    contradict();
    ASSERT_TRUE(find<Retract>());
    EXPECT_EQ(find<Retract>()->record.id(), second);
    EXPECT_EQ(master_.record(first)->liars.size(), 1u) << "to be taken out when it goes on";
}

TEST_F(AuditedMasterTest, NextProcessOfALiarIsNotWelcome) {
    submit(records_job(), 1);
    join(ann, 11);
    deliver(ann, lie(pull(ann, 1).at(0), ++results_));
    take(master_.on_disconnect(ann, now_s_));
    contradict();
    EXPECT_TRUE(find<Retract>());
    take(master_.on_connect(ann, "10.0.0.1:9", now_s_));
    wire::Hello hello(wire::Role::worker, "w11", 99);
    hello.threads = 2;
    hello.fingerprint = fingerprint;
    take(master_.on_message(ann, hello, 0, now_s_));
    EXPECT_EQ(sent<wire::Goodbye>(ann)->reason, wire::GoodbyeReason::refused);
}

}  // namespace
}  // namespace lumenfarm::testing
