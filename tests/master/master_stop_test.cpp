#include "tests/master/master_fixture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lumenfarm::testing {
namespace {

using ::testing::HasSubstr;

class StoppingMaster : public MasterTest {
protected:
    /// Ann has a lease of job 1, and her result of it is on its way to the disk, where it stays.
    wire::Lease send_result_to_held_disk() {
        submit(records_job(), 1);
        join(ann, 11);
        const auto leases = pull(ann, 2);
        disk_held_ = true;
        send_result(leases[0], 1);
        return leases[1];
    }
    void send_result(const wire::Lease& lease, std::uint64_t number) {
        const auto result = trace(lease, number);
        take(master_.on_message(ann, result.first, 0, now_s_));
        take(master_.on_message(ann, result.second, 0, now_s_));
    }
    void release_disk() {
        disk_held_ = false;
        take(master_.on_results_stored(std::exchange(held_, {}), thresholds(), now_s_));
    }
    /// Where the first effect is that `wanted` accepts.
    template <class Wanted>
    std::size_t place(Wanted wanted) const {
        return static_cast<std::size_t>(std::find_if(effects_.begin(), effects_.end(), wanted) - effects_.begin());
    }
};

TEST_F(StoppingMaster, AnswersWhatIsOnItsWayThenAsksForASnapshotAndSaysGoodbye) {
    const auto other = send_result_to_held_disk();
    take(master_.stop(now_s_));
    EXPECT_FALSE(sent<wire::Goodbye>(ann));
    EXPECT_FALSE(find<StoreSnapshot>());
    EXPECT_FALSE(master_.stopped());

    // nothing new is given or taken meanwhile: the worker keeps its result for the next life
    EXPECT_TRUE(pull(ann, 2).empty());
    send_result(other, 2);
    EXPECT_FALSE(sent<wire::ResultAck>(ann));
    EXPECT_FALSE(find<StoreResult>());

    release_disk();
    ASSERT_TRUE(sent<wire::ResultAck>(ann));
    EXPECT_EQ(sent<wire::ResultAck>(ann)->verdict, wire::Verdict::accepted);
    ASSERT_TRUE(find<StoreSnapshot>());
    EXPECT_TRUE(find<StoreSnapshot>()->last);
    ASSERT_TRUE(sent<wire::Goodbye>(ann));
    EXPECT_EQ(sent<wire::Goodbye>(ann)->reason, wire::GoodbyeReason::shutting_down);
    EXPECT_TRUE(master_.stopped());
    const auto message = [](auto is) {
        return [is](const Effect& effect) {
            const auto* send = std::get_if<Send>(&effect);
            return send && is(send->message);
        };
    };
    EXPECT_LT(place(message([](const auto& m) { return std::holds_alternative<wire::ResultAck>(m); })),
              place(message([](const auto& m) { return std::holds_alternative<wire::Goodbye>(m); })));
}

TEST_F(StoppingMaster, WaitsForASilentDiskOnlySoLong) {
    send_result_to_held_disk();
    take(master_.stop(now_s_));
    now_s_ += limits::stop_seconds / 2;
    take(master_.tick(now_s_));
    EXPECT_FALSE(master_.stopped());
    now_s_ += limits::stop_seconds;
    take(master_.tick(now_s_));
    EXPECT_TRUE(master_.stopped());
    EXPECT_TRUE(sent<wire::Goodbye>(ann));
    EXPECT_FALSE(sent<wire::ResultAck>(ann));
}

TEST_F(StoppingMaster, DoesNotWaitForADiskThatIsFull) {
    send_result_to_held_disk();
    take(master_.on_results_stored(std::exchange(held_, {}), no_space("the disk is full"), now_s_));
    take(master_.stop(now_s_));
    EXPECT_TRUE(master_.stopped());
    EXPECT_TRUE(sent<wire::Goodbye>(ann));
}

TEST_F(StoppingMaster, AskedAgainItHastens) {
    send_result_to_held_disk();
    take(master_.stop(now_s_));
    take(master_.stop(now_s_, 0));
    EXPECT_TRUE(master_.stopped());
}

TEST_F(StoppingMaster, AnswersACancelThatIsBeingStored) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    pull(ann, 1);
    disk_held_ = true;
    take(master_.on_message(embedding_session, wire::ControlRequest(job, wire::JobAction::cancel), 5, now_s_));
    const auto record = find<StoreRecord>();
    ASSERT_TRUE(record);
    take(master_.stop(now_s_));
    EXPECT_FALSE(master_.stopped());
    take(master_.on_record_stored(*record, {}, now_s_));
    EXPECT_TRUE(sent<wire::ControlReply>(embedding_session));
    EXPECT_TRUE(master_.stopped());
}

TEST_F(StoppingMaster, ASubmissionThatIsBeingStoredIsAnsweredAndLaterOnesAreNotTaken) {
    const wire::FileManifest manifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_));
    take(master_.on_message(embedding_session, wire::Submit(1, records_job(), manifest), 1, now_s_));
    const auto admit = find<Admit>();
    ASSERT_TRUE(admit);
    take(master_.on_message(embedding_session, wire::Submit(2, records_job(), manifest), 2, now_s_));
    take(master_.stop(now_s_));
    EXPECT_FALSE(master_.stopped());
    take(master_.on_admitted(*admit, std::vector<std::uint32_t>{}, now_s_));
    EXPECT_EQ(sent<wire::SubmitReply>(embedding_session)->job, 1u);
    EXPECT_FALSE(find<Admit>());
    EXPECT_FALSE(find<Prepare>());
    EXPECT_TRUE(master_.stopped());
}

TEST_F(StoppingMaster, OneWhoComesLateHearsGoodbye) {
    take(master_.stop(now_s_));
    EXPECT_TRUE(master_.stopped());
    take(master_.on_connect(bob, "10.0.0.2:1", now_s_));
    EXPECT_TRUE(sent<wire::Goodbye>(bob));
    EXPECT_TRUE(find<Close>());
}

TEST_F(MasterTest, WorkerThatSaysItEndsGivesItsLeasesToOthersAtOnce) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    ASSERT_EQ(leases.size(), 2u);
    take(master_.on_message(ann, wire::Goodbye(wire::GoodbyeReason::done, "the worker ends"), 0, now_s_));
    EXPECT_EQ(master_.status(job, now_s_)->leases_returned, 2u);
    EXPECT_EQ(master_.discarded(Discard::lease_returned), 2u);
    join(bob, 12);
    const auto given = pull(bob, 1);
    ASSERT_EQ(given.size(), 1u);
    EXPECT_EQ(given[0].range, leases[0].range);
}

TEST_F(MasterTest, SummaryIsALineThatAPersonReads) {
    EXPECT_EQ(master_.summary(now_s_), "no job runs; no workers");
    submit(records_job(), 1);
    join(ann, 11);
    deliver(ann, trace(pull(ann, 1)[0], 1));
    JobSpec later = records_job();
    later.priority = -1;
    submit(later, 2);
    EXPECT_EQ(master_.summary(now_s_), "job 1 at 10 %; 1 job waits; 1 worker with 2 threads");
    disk_held_ = true;
    const auto result = trace(pull(ann, 1)[0], 2);
    take(master_.on_message(ann, result.first, 0, now_s_));
    take(master_.on_message(ann, result.second, 0, now_s_));
    take(master_.on_results_stored(held_, no_space("no space left"), now_s_));
    EXPECT_THAT(master_.summary(now_s_), HasSubstr("the disk is full: no space left"));
    take(master_.stop(now_s_));
    EXPECT_THAT(master_.summary(now_s_), HasSubstr("ending: job 1"));
}

}  // namespace
}  // namespace lumenfarm::testing
