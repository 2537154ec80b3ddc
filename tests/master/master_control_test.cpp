#include "tests/master/control_fixture.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

/// What people do to jobs: pause, resume, extend, remove, priorities; and why a job waits.
namespace lumenfarm::testing {
namespace {

using wire::JobAction;
using wire::JobState;

TEST_F(ControlTest, PausedJobHandsInWhatIsDoneAndLetsGoOfItsSums) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    control(job, JobAction::pause);
    EXPECT_EQ(answered(), JobState::paused);
    EXPECT_TRUE(sent<wire::Drain>(ann));
    EXPECT_FALSE(find<PutAside>()) << "leases are outstanding";
    EXPECT_TRUE(pull(ann, 5).empty());
    EXPECT_EQ(deliver(ann, trace(leases[0], 1)), wire::Verdict::accepted);
    take(master_.on_message(
        ann, wire::ReturnLeases(wire::ReturnReason::ending, {wire::LeaseRef(leases[1].lease, leases[1].epoch)}), 0,
        now_s_));
    put_aside();
    EXPECT_TRUE(pull(ann, 5).empty());
    EXPECT_FALSE(find<Prepare>());
    EXPECT_EQ(state(job), JobState::paused);
    EXPECT_EQ(master_.status(job, now_s_)->committed, leases[0].range.count);
    EXPECT_NE(why(job).find("is paused"), std::string::npos);
}

TEST_F(ControlTest, PauseDoesNotWaitForSilentWorkersForLong) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    control(job, JobAction::pause);
    EXPECT_NE(why(job).find("waits for the results that 1 worker still have"), std::string::npos) << why(job);
    now_s_ += limits::finish_seconds + 1;
    take(master_.tick(now_s_));
    EXPECT_EQ(find<StoreLeases>()->ended.size(), 2u);
    put_aside();
    EXPECT_EQ(deliver(ann, trace(leases[0], 1)), wire::Verdict::job_gone);
}

TEST_F(ControlTest, ResumedJobGoesOnFromWhatTheDiskHas) {
    const JobId job = submit(records_job(), 1);
    control(job, JobAction::pause);
    put_aside();
    control(job, JobAction::resume);
    EXPECT_EQ(answered(), JobState::queued);
    prepare(half_done());
    join(ann, 11);
    EXPECT_EQ(state(job), JobState::running);
    finish(job);
    EXPECT_EQ(state(job), JobState::done);
    EXPECT_EQ(results_, 6u) << "the other half was there already";
}

TEST_F(ControlTest, LeasesOfBeforeAJobWasPutAsideDoNotComeBack) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    control(job, JobAction::pause);
    now_s_ += limits::finish_seconds + 1;
    take(master_.tick(now_s_));
    put_aside();
    control(job, JobAction::resume);
    RecoveredJob recovered;
    recovered.leases = {{lease.lease, 11, lease.range}};
    prepare(std::move(recovered));
    EXPECT_EQ(master_.status(job, now_s_)->leased, 0u);
}

TEST_F(ControlTest, LeasesThatAWorkerForgotWhileTheJobWasPausedAreGivenToOthers) {
    const JobId job = submit(records_job(), 1);
    JobRecord record = *master_.record(job);
    record.paused = record.begun = true;
    record.status.state = JobState::paused;
    master_ = MasterCore(policy());
    master_.restore(record);
    const LeaseId kept = lease_id(9, 1);
    join(ann, 11, {wire::LeaseProgress(job, kept, 0)});
    EXPECT_TRUE(sent<wire::JobGone>(ann));
    control(job, JobAction::resume);
    RecoveredJob recovered;
    recovered.leases = {{kept, 11, {0, 0, 1'000}}};
    prepare(std::move(recovered));
    EXPECT_EQ(master_.status(job, now_s_)->leased, 0u);
}

TEST_F(ControlTest, JobThatIsResumedWhileItIsBeingPutAsideGoesOn) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    pull(ann, 1);
    control(job, JobAction::pause);
    control(job, JobAction::resume);
    now_s_ += limits::finish_seconds + 1;
    take(master_.tick(now_s_));
    put_aside();
    EXPECT_TRUE(find<Prepare>());
}

TEST_F(ControlTest, JobWhoseLastResultsComeWhileItIsPausedIsDoneAndCanBeExtended) {
    JobSpec spec = records_job();
    spec.particles_per_set = 10'000;
    const JobId job = submit(spec, 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    control(job, JobAction::pause);
    for (const auto& lease : leases) deliver(ann, trace(lease, ++results_));
    store_solution();
    EXPECT_EQ(state(job), JobState::done);
    control(job, JobAction::extend, 20'000);
    EXPECT_TRUE(prepare_);
}

TEST_F(ControlTest, JobThatIsExtendedAndThenCancelledIsPreparedAnewBeforeItEnds) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    pull(ann, 1);
    control(job, JobAction::extend, 20'000);
    control(job, JobAction::cancel);
    now_s_ += limits::finish_seconds + 1;
    take(master_.tick(now_s_));
    put_aside();
    EXPECT_FALSE(solution_);
    prepare(half_done());
    ASSERT_TRUE(solution_);
    EXPECT_EQ(solution_->record.spec.particles, 20'000u);
}

TEST_F(ControlTest, QueuedJobIsPausedAndResumed) {
    JobSpec spec = records_job();
    spec.priority = 5;
    submit(spec, 1);
    const JobId second = submit(records_job(), 2);
    EXPECT_NE(why(second).find("waits for job 1, which has a higher priority (5, not 0)"), std::string::npos)
        << why(second);
    control(second, JobAction::pause);
    EXPECT_EQ(answered(), JobState::paused);
    control(second, JobAction::resume);
    EXPECT_EQ(answered(), JobState::queued);
}

TEST_F(ControlTest, PausedJobThatIsCancelledKeepsWhatWasDone) {
    const JobId job = submit(records_job(), 1);
    control(job, JobAction::pause);
    put_aside();
    control(job, JobAction::cancel);
    EXPECT_EQ(answered(), JobState::cancelled);
    prepare(half_done());
    ASSERT_TRUE(solution_);
    store_solution();
    EXPECT_EQ(state(job), JobState::cancelled);
    EXPECT_FALSE(master_.record(job)->complete);
}

TEST_F(ControlTest, PauseSurvivesTheMaster) {
    const JobId job = submit(records_job(), 1);
    control(job, JobAction::pause);
    MasterCore next(policy());
    next.restore(*master_.record(job));
    const Effects effects = next.tick(now_s_);
    EXPECT_TRUE(std::none_of(effects.begin(), effects.end(),
                             [](const Effect& effect) { return std::holds_alternative<Prepare>(effect); }));
    EXPECT_EQ(next.status(job, now_s_)->state, JobState::paused);
}

TEST_F(ControlTest, RunningJobIsExtended) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    control(job, JobAction::extend, 20'000);
    EXPECT_EQ(answered(), JobState::running);
    EXPECT_EQ(deliver(ann, trace(lease, ++results_)), wire::Verdict::accepted);
    put_aside();
    ASSERT_TRUE(prepare_);
    EXPECT_EQ(prepare_->job.spec.particles, 20'000u);
    RecoveredJob done;
    done.committed.resize(2);
    done.committed[lease.range.source].insert(lease.range.first, lease.range.first + lease.range.count);
    prepare(std::move(done));
    finish(job);
    EXPECT_EQ(results_, 21u);
    EXPECT_TRUE(master_.record(job)->complete);
}

TEST_F(ControlTest, WhatIsAskedWhileTheSolutionIsStoredIsDoneThen) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    trace_all();
    ASSERT_TRUE(solution_);
    control(job, JobAction::extend, 20'000);
    EXPECT_FALSE(answered());
    EXPECT_EQ(refused(), "");
    store_solution();
    EXPECT_EQ(answered(), JobState::queued);
    EXPECT_EQ(master_.record(job)->spec.particles, 20'000u);
}

TEST_F(ControlTest, WhatIsAskedWhileTheSolutionWaitsForSpaceIsRefused) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    trace_all();
    ASSERT_TRUE(solution_);
    control(job, JobAction::extend, 20'000);
    take(master_.on_solution_stored(*solution_, no_space("the disk is full"), now_s_));
    EXPECT_NE(refused().find("just ending"), std::string::npos);
    control(job, JobAction::extend, 20'000);
    EXPECT_NE(refused().find("just ending"), std::string::npos);
}

TEST_F(ControlTest, JobThatIsDoneIsExtendedFromItsSolution) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    finish(job);
    const Digest before = master_.record(job)->solution_file;
    disk_held_ = true;
    control(job, JobAction::extend, 20'000);
    const auto store = find<StoreRecord>();
    ASSERT_TRUE(store);
    EXPECT_EQ(store->basis, before);
    EXPECT_FALSE(store->record.has_solution);
    EXPECT_FALSE(find<Prepare>()) << "the basis does not last yet";
    take(master_.on_record_stored(*store, no_space("full"), now_s_));
    EXPECT_FALSE(find<Prepare>());
    now_s_ += limits::disk_retry_seconds + 1;
    take(master_.tick(now_s_));
    take(master_.on_record_stored(*find<StoreRecord>(), {}, now_s_));
    EXPECT_EQ(answered(), JobState::queued);
    EXPECT_TRUE(find<Prepare>());
}

TEST_F(ControlTest, CancelledJobIsExtendedToWhatItWasToHave) {
    const JobId job = submit(records_job(), 1);
    control(job, JobAction::cancel);
    store_solution();
    control(job, JobAction::extend, 10'000);
    EXPECT_EQ(answered(), JobState::queued);
    EXPECT_EQ(state(job), JobState::queued);
}

TEST_F(ControlTest, ExtensionThatCantBeIsRefusedWithTheReason) {
    const JobId job = submit(records_job(), 1);
    control(job, JobAction::extend, 9'999);
    EXPECT_EQ(refused(), "job 1 has 10000 particles; it can be extended to more, not to 9999");
    control(job, JobAction::extend, limits::particles_max + 1);
    EXPECT_NE(refused().find("particles is"), std::string::npos);
    control(77, JobAction::extend, 20'000);
    EXPECT_EQ(refused(), "there is no job 77");
}

TEST_F(ControlTest, RemovedJobIsForgottenWithTheFilesThatNobodyElseNeeds) {
    const JobId first = submit(records_job(), 1);
    control(first, JobAction::remove);
    EXPECT_EQ(refused(), "job 1 is not over; cancel it first");
    join(ann, 11);
    finish(first);
    JobRecord record = *master_.record(first);
    control(first, JobAction::remove);
    EXPECT_FALSE(answered());
    const auto removal = find<RemoveJob>();
    ASSERT_TRUE(removal);
    EXPECT_EQ(removal->files, (std::vector{record.status.scene, record.solution_file}));
    control(first, JobAction::extend, 20'000);
    EXPECT_NE(refused().find("just ending"), std::string::npos);
    take(master_.on_removed(*removal, {}, now_s_));
    EXPECT_EQ(answered(), JobState::done);
    EXPECT_FALSE(master_.status(first, now_s_));
}

TEST_F(ControlTest, SceneOfAnotherJobStays) {
    const JobId first = submit(records_job(), 1);
    join(ann, 11);
    finish(first);
    submit(records_job(), 2);
    control(first, JobAction::remove);
    ASSERT_TRUE(find<RemoveJob>());
    EXPECT_EQ(find<RemoveJob>()->files.size(), 1u);
}

TEST_F(ControlTest, OldJobsAreRemovedByAgeAndSize) {
    MasterPolicy policy = ControlTest::policy();
    policy.keep_seconds = 100;
    policy.keep_bytes = 1'000;
    policy.started_unix_seconds = 1'000'000;
    MasterCore master(policy);
    for (JobId job = 1; job <= 4; ++job) {
        JobRecord record;
        record.status.job = job;
        record.status.state = JobState::done;
        record.ended_unix_seconds = 1'000'000 - 120 + 40 * static_cast<std::int64_t>(job);
        record.solution_bytes = 400;
        record.has_solution = true;
        master.restore(record);
    }
    std::vector<JobId> removed;
    for (double now_s = 0; now_s < 80; ++now_s)
        for (const Effect& effect : master.tick(now_s))
            if (const auto* removal = std::get_if<RemoveJob>(&effect)) {
                removed.push_back(removal->job);
                master.on_removed(*removal, {}, now_s);
            }
    // the first two by size; the third is 100 s old after 100 s
    EXPECT_EQ(removed, (std::vector<JobId>{1, 2}));
}

TEST_F(ControlTest, JobsOfOnePriorityShareTheFarm) {
    JobSpec spec = records_job();
    spec.particles_per_set = 10;
    const JobId first = submit(spec, 1), second = submit(spec, 2);
    join(ann, 11);
    join(bob, 12);
    std::map<JobId, int> given;
    for (int i = 0; i < 20; ++i)
        for (const SessionId worker : {ann, bob})
            for (const auto& lease : pull(worker, 1)) ++given[lease.job];
    EXPECT_NEAR(given[first], 20, 2);
    EXPECT_NEAR(given[second], 20, 2);
}

TEST_F(ControlTest, HigherPriorityTakesAllAndThePlaceOfALowerOne) {
    JobSpec spec = records_job();
    for (std::uint64_t key = 1; key <= limits::active_jobs_max; ++key) submit(spec, key);
    join(ann, 11);
    spec.priority = 3;
    const JobId urgent = submit(spec, 99);
    // the youngest of the others makes room, and only that
    const auto aside = find<PutAside>();
    ASSERT_TRUE(aside);
    take(master_.tick(now_s_));
    EXPECT_FALSE(find<PutAside>());
    take(master_.on_put_aside(*aside, now_s_));
    EXPECT_EQ(state(limits::active_jobs_max), JobState::queued);
    prepare({});
    const auto leases = pull(ann, 10);
    ASSERT_EQ(leases.size(), 10u);
    for (const auto& lease : leases) EXPECT_EQ(lease.job, urgent);
}

TEST_F(ControlTest, WhySaysWhatARunningJobWaitsFor) {
    const JobId job = submit(records_job(), 1);
    EXPECT_EQ(why(job), "job 1 waits for a worker: none is connected");
    join(ann, 11);
    pull(ann, 1);
    EXPECT_EQ(why(job), "job 1 is being traced by 1 worker; nothing holds it up");
    pull(ann, 20);
    EXPECT_EQ(why(job), "job 1 waits for its last 10000 particles, which are with 1 worker");
    take(master_.on_disconnect(ann, now_s_));
    EXPECT_EQ(why(job),
              "job 1 waits for workers to come back: none is connected, and 11 leases are kept for them for a while");
}

TEST_F(ControlTest, SetThatKillsThreeWorkersIsSetAsideAndTheJobGoesOnAndThenPausesItself) {
    const JobId job = submit(records_job(), 1);
    std::optional<ParticleRange> poison;
    // every worker that gets the set dies with all that it has; the others do their work
    for (WorkerId worker = 100; state(job) == JobState::running && worker < 200; ++worker) {
        join(ann, worker);
        while (true) {
            // at first three sets are lost together
            const auto leases = pull(ann, worker < 102 ? 3 : 1);
            if (!poison) poison = leases.at(0).range;
            const auto kills = std::any_of(leases.begin(), leases.end(), [&](const wire::Lease& lease) {
                return lease.range.source == poison->source && lease.range.first < poison->first + poison->count &&
                       poison->first < lease.range.first + lease.range.count;
            });
            if (kills || leases.empty()) break;
            for (const auto& lease : leases) ASSERT_EQ(deliver(ann, trace(lease, ++results_)), wire::Verdict::accepted);
        }
        take(master_.on_disconnect(ann, now_s_));
        now_s_ += limits::reconnect_seconds + 10;
        take(master_.tick(now_s_));
    }
    EXPECT_EQ(state(job), JobState::paused);
    put_aside();
    const auto status = master_.status(job, now_s_);
    ASSERT_EQ(status->set_aside, std::vector{*poison});
    EXPECT_EQ(status->committed, 9'000u);
    EXPECT_NE(why(job).find("--light 0 --particles 0..999`"), std::string::npos) << why(job);
    control(job, JobAction::resume);
    EXPECT_TRUE(master_.status(job, now_s_)->set_aside.empty());
}

}  // namespace
}  // namespace lumenfarm::testing
