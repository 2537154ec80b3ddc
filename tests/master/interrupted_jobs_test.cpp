#include "tests/master/control_fixture.h"

#include <gtest/gtest.h>

#include <utility>

/// Jobs that were put aside, or can't be read, and go on later.
namespace lumenfarm::testing {
namespace {

using wire::JobAction;
using wire::JobState;

/// A job that made room and is to go on first, since a worker waits for it, is not in the way of a more urgent one.
TEST_F(ControlTest, JobThatWaitsForAPlaceDoesNotHideAMoreUrgentOne) {
    JobSpec spec = records_job();
    JobRecord waiting;
    waiting.status.job = 1;
    waiting.spec = spec;
    waiting.begun = true;
    waiting.status.state = JobState::running;
    waiting.status.scene = scene_digest(bytes_);
    spec.priority = 10;
    for (std::uint64_t key = 2; key <= limits::active_jobs_max + 1; ++key) submit(spec, key);
    waiting.status.job = 50;
    master_.restore(waiting);
    spec.priority = 20;
    submit(spec, 99);
    EXPECT_TRUE(find<PutAside>());
}

TEST_F(ControlTest, JobWhoseSceneCannotBeReadIsHeldBackWithAllThatItHas) {
    const JobId job = submit(records_job(), 1);
    control(job, JobAction::pause);
    put_aside();
    control(job, JobAction::resume);
    prepare_.reset();
    take(master_.on_prepared(job, bad_input("the scene is damaged"), now_s_));
    EXPECT_EQ(state(job), JobState::paused);
    ASSERT_TRUE(find<StoreRecord>());
    EXPECT_FALSE(find<StoreRecord>()->record.over()) << "what it has would be removed";
    EXPECT_NE(why(job).find("can't go on: the scene is damaged; `lumenfarm resume 1` tries again"), std::string::npos)
        << why(job);
    control(job, JobAction::resume);
    EXPECT_EQ(why(job), "the master reads the scene of job 1");
    prepare(half_done());
    EXPECT_EQ(state(job), JobState::running);

    // who cancels is not promised what can't be kept
    control(job, JobAction::pause);
    put_aside();
    control(job, JobAction::cancel);
    prepare_.reset();
    take(master_.on_prepared(job, failed("cannot read the scene: Input/output error"), now_s_));
    EXPECT_EQ(state(job), JobState::paused);
    control(job, JobAction::cancel);
    EXPECT_EQ(state(job), JobState::cancelled);

    // one that has done nothing has nothing to lose
    JobSpec spec = records_job();
    spec.seed = 2;
    take(master_.on_message(
        embedding_session,
        wire::Submit(7, spec, wire::FileManifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_))), 1,
        now_s_));
    take(master_.on_admitted(*find<Admit>(), std::vector<std::uint32_t>{}, now_s_));
    const JobId fresh = sent<wire::SubmitReply>(embedding_session)->job;
    prepare_.reset();
    take(master_.on_prepared(fresh, bad_input("the scene is damaged"), now_s_));
    EXPECT_EQ(state(fresh), JobState::failed);
}

TEST_F(ControlTest, JobWaitsWhereTooManyFilesAreOpen) {
    const JobId job = submit(records_job(), 1);
    control(job, JobAction::pause);
    put_aside();
    control(job, JobAction::resume);
    prepare_.reset();
    take(master_.on_prepared(job, no_space("cannot open the scene: Too many open files"), now_s_));
    EXPECT_EQ(state(job), JobState::queued);
    EXPECT_FALSE(find<Prepare>());
    EXPECT_NE(why(job).find("Too many open files"), std::string::npos);
    now_s_ += limits::disk_retry_seconds + 1;
    take(master_.tick(now_s_));
    EXPECT_TRUE(find<Prepare>());
}

TEST_F(ControlTest, WorkerThatHoldsResultsOfAJobThatWaitsIsToldThatTheyAreNobodys) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1).at(0);
    take(master_.on_disconnect(ann, now_s_));
    control(job, JobAction::extend, 20'000);
    now_s_ += limits::finish_seconds + 1;
    take(master_.tick(now_s_));
    ASSERT_TRUE(find<PutAside>());
    join(ann, 11, {{job, lease.lease, 0}});
    EXPECT_TRUE(sent<wire::JobGone>(ann)) << "they would be stale when it goes on";

    // in the next life the job is waited for, until it is paused
    JobRecord record = *master_.record(job);
    record.status.job = 50;
    master_ = MasterCore(policy());
    for (std::uint64_t key = 2; key <= limits::active_jobs_max + 1; ++key) submit(records_job(), key);
    master_.restore(record);
    join(bob, 12, {{50, lease.lease, 0}});
    EXPECT_FALSE(sent<wire::JobGone>(bob));
    control(50, JobAction::pause);
    EXPECT_TRUE(sent<wire::JobGone>(bob));
}

TEST_F(ControlTest, TimeBetweenTwoRunsOfAJobIsNotItsOwn) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 20);
    now_s_ += 10;
    for (const auto& lease : leases) deliver(ann, trace(lease, ++results_));
    EXPECT_EQ(solution_->effort.elapsed_s, 10);
    store_solution();
    now_s_ += 86'400;
    control(job, JobAction::extend, 20'000);
    take(master_.on_record_stored(*find<StoreRecord>(), {}, now_s_));
    RecoveredJob recovered;
    recovered.effort = {10, 1};
    prepare(std::move(recovered));
    pull(ann, 1);
    now_s_ += 5;
    EXPECT_EQ(master_.status(job, now_s_)->elapsed_seconds, 15);
}

}  // namespace
}  // namespace lumenfarm::testing
