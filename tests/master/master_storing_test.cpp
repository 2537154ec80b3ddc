#include "tests/master/master_fixture.h"

#include <gtest/gtest.h>

#include <utility>

namespace lumenfarm::testing {
namespace {

TEST_F(MasterTest, SolutionWaitsForAFullDisk) {
    JobSpec spec = records_job();
    spec.particles_per_set = 1'000'000;
    const JobId job = submit(spec, 1);
    join(ann, 11);
    std::uint64_t number = 0;
    for (const auto& lease : pull(ann, 4)) deliver(ann, trace(lease, ++number));
    take(master_.on_solution_stored(*solution_, no_space("the disk is full"), now_s_));
    EXPECT_EQ(master_.status(job, now_s_)->state, wire::JobState::running);
    EXPECT_NE(master_.status(job, now_s_)->sentence.find("the disk is full"), std::string::npos);
    take(master_.tick(now_s_));
    EXPECT_FALSE(find<StoreSolution>());
    now_s_ += limits::disk_retry_seconds + 1;
    take(master_.tick(now_s_));
    ASSERT_TRUE(find<StoreSolution>());
    store_solution();
    EXPECT_EQ(master_.status(job, now_s_)->state, wire::JobState::done);
    EXPECT_EQ(master_.status(job, now_s_)->sentence.find("disk"), std::string::npos);
}

TEST_F(MasterTest, NobodyIsAnsweredBeforeAResultLasts) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    disk_held_ = true;
    const auto result = trace(lease, 1);
    take(master_.on_message(ann, result.first, 0, now_s_));
    take(master_.on_message(ann, result.second, 0, now_s_));
    EXPECT_FALSE(sent<wire::ResultAck>(ann));
    EXPECT_EQ(master_.status(job, now_s_)->committed, 0u);
    EXPECT_GT(master_.staged_bytes(), 0u);
    take(master_.on_results_stored(held_, thresholds(), now_s_));
    EXPECT_EQ(sent<wire::ResultAck>(ann)->verdict, wire::Verdict::accepted);
    EXPECT_EQ(master_.status(job, now_s_)->committed, lease.range.count);
    EXPECT_EQ(master_.staged_bytes(), 0u);
    EXPECT_EQ(pull(ann, 1)[0].keep_threshold, 100u) << "the disk's side knows it";
}

TEST_F(MasterTest, ResultOnItsWayToTheDiskMayComeAgainOverANewConnection) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    disk_held_ = true;
    const auto result = trace(lease, 1);
    take(master_.on_message(ann, result.first, 0, now_s_));
    take(master_.on_message(ann, result.second, 0, now_s_));
    take(master_.on_disconnect(ann, now_s_));
    join(bob, 11, {wire::LeaseProgress(lease.job, lease.lease, 0)});
    EXPECT_TRUE(sent<wire::JobInfo>(bob));
    take(master_.on_message(bob, result.first, 0, now_s_));
    take(master_.on_message(bob, result.second, 0, now_s_));
    EXPECT_FALSE(sent<wire::ResultAck>(bob));
    take(master_.on_results_stored(held_, thresholds(), now_s_));
    EXPECT_EQ(all_sent<wire::ResultAck>(bob).size(), 1u);
    EXPECT_EQ(sent<wire::ResultAck>(bob)->verdict, wire::Verdict::accepted);
}

TEST_F(MasterTest, AnothersResultIsAnsweredWhenTheFirstOneLasts) {
    JobSpec spec = records_job();
    spec.particles_per_set = 1'000'000;
    submit(spec, 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    join(bob, 12);
    pull(bob, 1);
    now_s_ = 3 * limits::straggler_targets;
    take(master_.tick(now_s_));
    const auto twin = sent<wire::Lease>(bob);
    ASSERT_TRUE(twin);
    disk_held_ = true;
    for (const auto& [session, result] : {std::pair(ann, trace(leases[0], 1)), std::pair(bob, trace(*twin, 1))}) {
        take(master_.on_message(session, result.first, 0, now_s_));
        take(master_.on_message(session, result.second, 0, now_s_));
        EXPECT_FALSE(sent<wire::ResultAck>(session));
    }
    take(master_.on_results_stored(held_, thresholds(), now_s_));
    EXPECT_EQ(sent<wire::ResultAck>(ann)->verdict, wire::Verdict::accepted);
    EXPECT_EQ(sent<wire::ResultAck>(bob)->verdict, wire::Verdict::already_merged);
}

TEST_F(MasterTest, WhatARepeatedResultCoveredBesidesIsGivenOutAgain) {
    JobSpec spec = records_job();
    spec.particles_per_set = 1'000'000;
    const JobId job = submit(spec, 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    ParticleRange half = leases[0].range;
    half.count /= 2;
    disk_held_ = true;
    const auto first = trace(leases[0], 1, half), whole = trace(leases[0], 2);
    for (const auto& result : {first, whole}) {
        take(master_.on_message(ann, result.first, 0, now_s_));
        take(master_.on_message(ann, result.second, 0, now_s_));
    }
    take(master_.on_results_stored(held_, thresholds(), now_s_));
    EXPECT_EQ(all_sent<wire::ResultAck>(ann)[1].verdict, wire::Verdict::already_merged);
    EXPECT_EQ(master_.status(job, now_s_)->leased, leases[1].range.count) << "ann has forgotten the first lease";
}

TEST_F(MasterTest, FullDiskPausesTheJobsAndTheSameResultsAreTriedAgain) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    disk_held_ = true;
    const auto result = trace(leases[0], 1);
    take(master_.on_message(ann, result.first, 0, now_s_));
    take(master_.on_message(ann, result.second, 0, now_s_));
    take(master_.on_results_stored(held_, no_space("the disk is full"), now_s_));
    EXPECT_NE(master_.status(job, now_s_)->sentence.find("the disk is full"), std::string::npos);
    EXPECT_TRUE(pull(ann, 5).empty()) << "no more work until there is room";
    const auto tickets = std::exchange(held_, {});
    now_s_ += limits::disk_retry_seconds + 1;
    take(master_.tick(now_s_));
    EXPECT_EQ(held_, tickets);
    take(master_.on_results_stored(held_, thresholds(), now_s_));
    EXPECT_EQ(sent<wire::ResultAck>(ann)->verdict, wire::Verdict::accepted);
    EXPECT_EQ(all_sent<wire::Lease>(ann).size(), 5u) << "and it goes on";
    EXPECT_EQ(master_.status(job, now_s_)->sentence.find("disk"), std::string::npos);
}

TEST_F(MasterTest, SnapshotsAreAskedForWhileTheDiskIsFullAndSaySo) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 1);
    disk_held_ = true;
    const auto result = trace(leases[0], 1);
    take(master_.on_message(ann, result.first, 0, now_s_));
    take(master_.on_message(ann, result.second, 0, now_s_));
    now_s_ += 11;
    take(master_.tick(now_s_));
    ASSERT_TRUE(find<StoreSnapshot>());
    EXPECT_FALSE(find<StoreSnapshot>()->disk_is_full);
    take(master_.on_snapshot_stored(*find<StoreSnapshot>(), now_s_));
    take(master_.on_results_stored(std::exchange(held_, {}), no_space("the disk is full"), now_s_));
    now_s_ += 11;
    take(master_.tick(now_s_));
    ASSERT_TRUE(find<StoreSnapshot>());
    EXPECT_TRUE(find<StoreSnapshot>()->disk_is_full);
}

TEST_F(MasterTest, JobsOfAnEarlierLifeAreKnownAndUnfinishedOnesGoOn) {
    JobRecord done;
    done.status.job = 3;
    done.status.state = wire::JobState::done;
    done.has_solution = true;
    JobRecord running;
    running.spec = records_job();
    running.status.job = 4;
    running.status.state = wire::JobState::running;
    master_.restore(done);
    master_.restore(running);
    take(master_.tick(now_s_));
    EXPECT_EQ(find<Prepare>()->job.id(), 4u);
    take(master_.on_message(embedding_session, wire::FetchRequest(3), 1, now_s_));
    EXPECT_TRUE(sent<wire::FetchReply>(embedding_session));
    EXPECT_EQ(submit(records_job(), 1), 5u) << "numbers go on";
}

/// A master that starts on a job of which an earlier life had given out leases.
class RestartedMasterTest : public MasterTest {
protected:
    RestartedMasterTest() {
        JobRecord running;
        running.spec = records_job();
        running.status.job = 4;
        running.status.state = wire::JobState::running;
        running.begun = true;
        master_.restore(running);
    }
    static constexpr LeaseId kept = lease_id(9, 1), lost = lease_id(9, 2);
    static RecoveredJob recovered() {
        RecoveredJob job;
        job.leases = {{kept, 11, {0, 0, 1'000}}, {lost, 11, {0, 1'000, 1'000}}};
        return job;
    }
    static wire::Lease lease() { return {kept, 9, 4, {0, 0, 1'000}, 0}; }
};

TEST_F(RestartedMasterTest, WorkerThatComesBackFirstIsAskedForItsResultsWhenTheJobRuns) {
    join(ann, 11, {wire::LeaseProgress(4, kept, 0)});
    EXPECT_FALSE(sent<wire::JobInfo>(ann));
    take(master_.tick(now_s_), true);
    prepare(recovered());
    EXPECT_TRUE(sent<wire::JobInfo>(ann));
    EXPECT_EQ(master_.status(4, now_s_)->leased, 1'000u) << "the other lease it holds no more";
    EXPECT_EQ(deliver(ann, trace(lease(), 7)), wire::Verdict::accepted);
    EXPECT_EQ(master_.status(4, now_s_)->committed, 1'000u);
}

TEST_F(RestartedMasterTest, WorkerThatComesBackLaterFindsItsLeases) {
    take(master_.tick(now_s_));
    prepare(recovered());
    now_s_ = limits::restart_seconds - 1;
    take(master_.tick(now_s_));
    join(ann, 11, {wire::LeaseProgress(4, kept, 0)});
    EXPECT_TRUE(sent<wire::JobInfo>(ann));
    EXPECT_EQ(deliver(ann, trace(lease(), 7)), wire::Verdict::accepted);
}

TEST_F(RestartedMasterTest, LeasesOfWorkersThatDoNotComeBackAreGivenToOthers) {
    take(master_.tick(now_s_));
    prepare(recovered());
    EXPECT_EQ(master_.status(4, now_s_)->leased, 2'000u);
    now_s_ = limits::restart_seconds + 1;
    take(master_.tick(now_s_));
    EXPECT_EQ(master_.status(4, now_s_)->leased, 0u);
    join(ann, 11, {wire::LeaseProgress(4, kept, 0)});
    EXPECT_EQ(deliver(ann, trace(lease(), 7)), wire::Verdict::stale);
}

TEST_F(RestartedMasterTest, LeasesThatAreReturnedWhileTheJobIsPreparedAreFree) {
    join(ann, 11, {wire::LeaseProgress(4, kept, 0)});
    take(master_.on_message(ann, wire::ReturnLeases(wire::ReturnReason::ending, {wire::LeaseRef(kept, 9)}), 0, now_s_));
    take(master_.tick(now_s_));
    prepare(recovered());
    EXPECT_EQ(master_.status(4, now_s_)->leased, 0u);
}

TEST_F(RestartedMasterTest, ResultsOfAJobThatIsOverAreNotAskedFor) {
    join(ann, 11, {wire::LeaseProgress(3, kept, 0)});
    ASSERT_TRUE(sent<wire::JobGone>(ann));
    EXPECT_EQ(sent<wire::JobGone>(ann)->job, 3u);
}

TEST_F(RestartedMasterTest, GoesOnWithWhatWasCommitted) {
    take(master_.tick(now_s_));
    RecoveredJob job = recovered();
    job.leases.clear();
    job.committed.resize(2);
    job.committed[0].insert(0, 3'000);
    job.balance.particles = 3'000;
    job.effort = {70, 5};
    prepare(std::move(job));
    const auto status = master_.status(4, now_s_);
    EXPECT_EQ(status->state, wire::JobState::running);
    EXPECT_EQ(status->committed, 3'000u);
    EXPECT_EQ(status->elapsed_seconds, 70);
    join(ann, 11);
    for (const auto& lease : pull(ann, 9)) EXPECT_TRUE(lease.range.source == 1 || lease.range.first >= 3'000);
}

TEST_F(RestartedMasterTest, JobThatWasToBeCancelledEnds) {
    JobRecord record = *master_.record(4);
    record.status.state = wire::JobState::running;
    record.cancel_asked = true;
    master_.restore(record);
    take(master_.tick(now_s_));
    prepare({});
    EXPECT_TRUE(find<StoreSolution>());
}

TEST_F(MasterTest, ResultThatFoundNoRoomIsTriedAgainThoughALaterOneFoundSome) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    disk_held_ = true;
    std::uint64_t number = 0;
    for (const auto& lease : leases) {
        const auto result = trace(lease, ++number);
        take(master_.on_message(ann, result.first, 0, now_s_));
        take(master_.on_message(ann, result.second, 0, now_s_));
    }
    const auto tickets = std::exchange(held_, {});
    ASSERT_EQ(tickets.size(), 2u);
    take(master_.on_results_stored({&tickets[0], 1}, no_space("the disk is full"), now_s_));
    take(master_.on_results_stored({&tickets[1], 1}, thresholds(), now_s_));
    take(master_.tick(now_s_));
    EXPECT_EQ(held_, std::vector{tickets[0]});
    take(master_.on_results_stored(held_, thresholds(), now_s_));
    EXPECT_EQ(master_.status(job, now_s_)->committed, leases[0].range.count + leases[1].range.count);
}

TEST_F(MasterTest, CancelIsAnsweredWhenItLasts) {
    const JobId job = submit(records_job(), 1);
    disk_held_ = true;
    take(master_.on_message(embedding_session, wire::ControlRequest(job, wire::JobAction::cancel), 8, now_s_));
    EXPECT_FALSE(sent<wire::ControlReply>(embedding_session));
    const auto record = find<StoreRecord>();
    ASSERT_TRUE(record);
    EXPECT_TRUE(record->record.cancel_asked);
    take(master_.on_record_stored(*record, {}, now_s_));
    EXPECT_FALSE(sent<wire::ControlReply>(embedding_session)) << "nothing is outstanding: the solution is on its way";
    store_solution();
    EXPECT_EQ(sent<wire::ControlReply>(embedding_session)->state, wire::JobState::cancelled);
}

TEST_F(MasterTest, CancelThatFindsNoRoomIsNotAnsweredHoweverOftenItIsAskedFor) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    pull(ann, 1);
    disk_held_ = true;
    take(master_.on_message(embedding_session, wire::ControlRequest(job, wire::JobAction::cancel), 8, now_s_));
    take(master_.on_record_stored(*find<StoreRecord>(), no_space("the disk is full"), now_s_));
    take(master_.on_message(embedding_session, wire::ControlRequest(job, wire::JobAction::cancel), 9, now_s_));
    EXPECT_FALSE(sent<wire::ControlReply>(embedding_session));
    now_s_ += limits::disk_retry_seconds + 1;
    take(master_.tick(now_s_));
    ASSERT_TRUE(find<StoreRecord>());
    take(master_.on_record_stored(*find<StoreRecord>(), {}, now_s_));
    EXPECT_EQ(all_sent<wire::ControlReply>(embedding_session).size(), 2u);
}

TEST_F(MasterTest, RecordThatFoundNoRoomNeverFollowsTheSolution) {
    const JobId job = submit(records_job(), 1);
    disk_held_ = true;
    take(master_.on_message(embedding_session, wire::ControlRequest(job, wire::JobAction::cancel), 8, now_s_));
    const auto record = find<StoreRecord>();
    ASSERT_TRUE(record && solution_);
    take(master_.on_record_stored(*record, no_space("the disk is full"), now_s_));
    store_solution();
    EXPECT_TRUE(sent<wire::ControlReply>(embedding_session));
    now_s_ += limits::disk_retry_seconds + 1;
    take(master_.tick(now_s_));
    EXPECT_FALSE(find<StoreRecord>());
    EXPECT_EQ(master_.status(job, now_s_)->state, wire::JobState::cancelled);
}

TEST_F(RestartedMasterTest, CancelBeforeTheJobRunsAgainKeepsWhatWasCommitted) {
    take(master_.tick(now_s_));
    take(master_.on_message(embedding_session, wire::ControlRequest(4, wire::JobAction::cancel), 8, now_s_));
    EXPECT_TRUE(sent<wire::ControlReply>(embedding_session));
    EXPECT_TRUE(master_.record(4)->cancel_asked);
    RecoveredJob job;
    job.committed.resize(2);
    job.committed[0].insert(0, 3'000);
    job.balance.particles = 3'000;
    prepare(std::move(job));
    ASSERT_TRUE(solution_);
    EXPECT_EQ(solution_->record.status.committed, 3'000u);
}

TEST_F(MasterTest, LeasesAreKeptFromTheirGivingToTheirEnd) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    const auto given = find<StoreLeases>();
    ASSERT_TRUE(given);
    ASSERT_EQ(given->given.size(), 1u);
    EXPECT_EQ(given->given[0].lease.lease, lease.lease);
    EXPECT_EQ(given->given[0].lease.worker, 11u);
    EXPECT_EQ(given->given[0].lease.range, lease.range);
    deliver(ann, trace(lease, 1));
    ASSERT_TRUE(find<StoreLeases>());
    EXPECT_EQ(find<StoreLeases>()->ended, std::vector<LeaseId>{lease.lease});
}

TEST_F(MasterTest, SnapshotsAreAskedForAgainAndAgain) {
    submit(records_job(), 1);
    int asked = 0;
    for (; now_s_ <= 60; now_s_ += 0.5) {
        take(master_.tick(now_s_));
        const auto store = find<StoreSnapshot>();
        if (!store) continue;
        ++asked;
        take(master_.on_snapshot_stored(*store, now_s_));
    }
    EXPECT_EQ(asked, 6);
}

TEST_F(MasterTest, ASnapshotThatTakesLongPutsTheNextOneOff) {
    submit(records_job(), 1);
    std::vector<double> asked_s;
    std::optional<StoreSnapshot> on_its_way;
    for (; now_s_ <= 60; now_s_ += 0.5) {
        take(master_.tick(now_s_));
        if (const auto store = find<StoreSnapshot>()) {
            asked_s.push_back(now_s_);
            on_its_way = store;
        }
        if (on_its_way && now_s_ == asked_s.back() + 5) {
            take(master_.on_snapshot_stored(*on_its_way, now_s_));
            on_its_way.reset();
        }
    }
    EXPECT_EQ(asked_s, (std::vector<double>{10, 10 + 5 + 4 * 5, 60}));
}

}  // namespace
}  // namespace lumenfarm::testing
