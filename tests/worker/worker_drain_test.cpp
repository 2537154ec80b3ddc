#include "tests/worker/worker_fixture.h"

#include <gtest/gtest.h>

#include <utility>

/// How a worker ends.
namespace lumenfarm::worker {
namespace {

TEST_F(WorkerTest, DrainSendsWhatIsDoneReturnsTheRestAndFinishes) {
    welcome();
    ready();
    hear(lease(1, 100'000));
    hear(lease(2, 100'000));
    hear(lease(3, 100'000));
    take(core_.drain(now_s_));
    EXPECT_EQ(sent<wire::ReturnLeases>()->leases.size(), 1u) << "the set that waits";
    EXPECT_EQ(all<InterruptSlot>().size(), 2u);
    SlotReport stopped;
    stopped.set_left = true;
    stopped.result = parcel(lease(1, 100'000), 2'048);
    take(core_.on_slot(0, std::move(stopped), now_s_));
    ASSERT_EQ(find<TellSlot>()->ask, SlotAsk::abandon);
    EXPECT_FALSE(sent<wire::ReturnLeases>()) << "not before its result is answered";
    take(core_.on_slot(0, SlotReport{}, now_s_));
    SlotReport untouched;
    untouched.set_left = true;
    take(core_.on_slot(1, untouched, now_s_));
    EXPECT_EQ(sent<wire::ReturnLeases>()->leases.size(), 1u);
    take(core_.on_slot(1, SlotReport{}, now_s_));
    EXPECT_FALSE(find<Finished>());
    const auto done = pump();
    ASSERT_EQ(done.size(), 1u);
    hear(wire::ResultAck(1, done[0].result, wire::Verdict::accepted));
    EXPECT_EQ(sent<wire::ReturnLeases>()->leases.size(), 1u);
    EXPECT_TRUE(find<Finished>());
}

TEST_F(WorkerTest, DrainEndsInTimeThoughTheMasterIsSilent) {
    welcome();
    ready();
    hear(lease(1));
    take(core_.drain(now_s_));
    EXPECT_FALSE(find<Finished>());
    take(core_.tick(limits::drain_seconds));
    EXPECT_TRUE(find<Finished>());
}

TEST_F(WorkerTest, DrainTimeIsThatOfTheConfiguration) {
    core_ = WorkerCore(identity(), 3);
    welcome();
    ready();
    hear(lease(1));
    take(core_.drain(now_s_));
    take(core_.tick(now_s_ + 2.9));
    EXPECT_FALSE(find<Finished>());
    take(core_.tick(now_s_ + 3));
    EXPECT_TRUE(find<Finished>());
}

TEST_F(WorkerTest, EndsNowThoughASlotStillTraces) {
    welcome();
    ready();
    hear(lease(1));
    hear(lease(2));
    hear(lease(3));
    take(core_.drain(now_s_));
    EXPECT_FALSE(find<Finished>());
    take(core_.end_now(now_s_));
    EXPECT_TRUE(find<Finished>());
    EXPECT_TRUE(all<StartSlot>().empty());
}

TEST_F(WorkerTest, EndNowAloneReturnsWhatWaitsAndEnds) {
    welcome();
    ready();
    for (std::uint64_t i = 1; i <= 3; ++i) hear(lease(i));
    take(core_.end_now(now_s_));
    EXPECT_EQ(sent<wire::ReturnLeases>()->leases.size(), 1u);
    EXPECT_TRUE(find<Finished>());
}

TEST_F(WorkerTest, SummaryIsALineThatAPersonReads) {
    EXPECT_EQ(core_.summary(), "waits for work");
    welcome();
    ready();
    hear(lease(1, 100'000));
    EXPECT_EQ(core_.summary(), "traces job 1 on 1 of 2 threads");
    hear(lease(2, 100'000));
    take(core_.drain(now_s_));
    EXPECT_EQ(core_.summary(), "ending: traces job 1 on 2 of 2 threads");
    finish_set(0, lease(1));
    finish_set(1, lease(2));
    EXPECT_EQ(core_.summary(), "ending: 2 results not acknowledged yet");
}

TEST_F(WorkerTest, ResultsThatAreLeftWhenItEndsAreCounted) {
    welcome();
    ready();
    hear(lease(1));
    finish_set(0, lease(1));
    take(core_.drain(now_s_));
    take(core_.tick(limits::drain_seconds));
    ASSERT_TRUE(find<Finished>());
    EXPECT_EQ(discarded(Discard::result_undelivered), 1u);
    EXPECT_NE(core_.counts().text().find("discarded: result_undelivered 1"), std::string::npos);
}

}  // namespace
}  // namespace lumenfarm::worker
