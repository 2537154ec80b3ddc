#include "tests/relay/relay_fixture.h"

/// A relay whose connection to the master above comes and goes.
namespace lumenfarm::relay {
namespace {

TEST_F(Relay, LostConnectionStatesWhatItHolds) {
    join(ann, 11);
    open_job();
    lease(70, 0, 2'000);
    lease(71, 2'000, 2'000);
    const auto sets = pull(ann, 2);
    ASSERT_EQ(sets.size(), 2u);
    for (const auto& set : sets) EXPECT_EQ(deliver(ann, set, set.lease), wire::Verdict::accepted);
    reconnect();
    const auto progress = sent_up<wire::Progress>();
    ASSERT_TRUE(progress);
    std::set<std::uint64_t> held;
    for (const auto& each : progress->leases) held.insert(each.lease);
    EXPECT_EQ(held, (std::set<std::uint64_t>{70, 71})) << "one is in a result that has no answer";
    EXPECT_TRUE(handed_up().empty()) << "the master has not told of the job again";
    open_job();
    EXPECT_EQ(handed_up().size(), 2u);
}

TEST_F(Relay, AwayForTooLongItDropsItsSets) {
    join(ann, 11);
    open_job();
    lease(70, 0, 2'000);
    const auto sets = pull(ann, 1);
    reconnect(limits::reconnect_seconds + 1);
    EXPECT_EQ(sent_up<wire::Progress>()->leases.size(), 0u);
    EXPECT_FALSE(all_sent<wire::JobGone>(ann).empty()) << "nothing is held of the job";
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::job_gone);
}

TEST_F(Relay, AwayForTooLongItReturnsALeaseOfWhichAResultIsOnItsWayAndTheRestIsDropped) {
    join(ann, 11);
    open_job(Packing::maps);
    lease(70, 0, 2'000);
    const auto sets = pull(ann, 2);
    ASSERT_EQ(sets.size(), 2u);
    lease(71, 2'000, 2'000);
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::accepted);
    now_s_ += 3;
    tick();
    EXPECT_EQ(handed_up().size(), 1u);
    take(core_.on_upstream_lost({}, now_s_));
    now_s_ += limits::reconnect_seconds + 1;
    EXPECT_EQ(deliver(ann, sets[1], 2), wire::Verdict::accepted);
    take(core_.on_upstream_open(now_s_));
    above(wire::Welcome(6));
    const auto progress = sent_up<wire::Progress>();
    ASSERT_EQ(progress->leases.size(), 1u);
    EXPECT_EQ(progress->leases[0].lease, 70u) << "the result that has no answer claims a part of it";
    open_job(Packing::maps);
    const auto results = handed_up();
    ASSERT_EQ(results.size(), 1u);
    above(wire::ResultAck(1, results[0].result, wire::Verdict::accepted));
    const auto returned = sent_up<wire::ReturnLeases>();
    ASSERT_TRUE(returned) << "or the master waits for the other part for ever";
    EXPECT_EQ(returned->leases, (std::vector{wire::LeaseRef(70, 1)}));
}

TEST_F(Relay, RefusedResultTakesItsLeasesAlong) {
    join(ann, 11);
    open_job();
    lease(70, 0, 2'000);
    const auto sets = pull(ann, 2);
    ASSERT_EQ(sets.size(), 2u);
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::accepted);
    const auto results = handed_up();
    ASSERT_EQ(results.size(), 1u);
    above(wire::ResultAck(1, results[0].result, wire::Verdict::stale, "not current"));
    const auto returned = sent_up<wire::ReturnLeases>();
    ASSERT_TRUE(returned);
    EXPECT_EQ(returned->leases, (std::vector{wire::LeaseRef(70, 1)}));
    EXPECT_EQ(deliver(ann, sets[1], 2), wire::Verdict::already_merged) << "it is nobody's here";
    EXPECT_TRUE(handed_up().empty());
    lease(72, 0, 2'000);
    EXPECT_EQ(pull(ann, 1).size(), 1u) << "the master may lend the same again";
}

TEST_F(Relay, ReconnectedWhileAJobDrainsItHandsUpWhatItHas) {
    join(ann, 11);
    open_job(Packing::maps);
    lease(70, 0, 2'000);
    const auto sets = pull(ann, 1);
    above(wire::Drain(1));
    reconnect();
    open_job(Packing::maps);
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::accepted);
    EXPECT_EQ(handed_up().size(), 1u);
    EXPECT_EQ(kept_, 1u) << "nothing was fetched again";
}

TEST_F(Relay, WithoutWorkersItGivesEverythingBack) {
    join(ann, 11);
    open_job();
    lease(70, 0, 2'000);
    take(core_.on_disconnect(ann, now_s_));
    tick();
    now_s_ += limits::reconnect_seconds - 1;
    tick();
    EXPECT_FALSE(sent_up<wire::ReturnLeases>()) << "they may come back";
    now_s_ += 2;
    tick();
    EXPECT_TRUE(sent_up<wire::ReturnLeases>());
}

TEST_F(Relay, OneThatIsItsOwnUpstreamIsToldSo) {
    take(core_.on_connect(ann, "127.0.0.1:1", now_s_));
    below(ann, wire::Hello(wire::Role::relay, "relay", own_instance));
    const auto goodbyes = all_sent<wire::Goodbye>(ann);
    ASSERT_EQ(goodbyes.size(), 1u);
    EXPECT_EQ(goodbyes[0].reason, wire::GoodbyeReason::refused);
    effects_.clear();
    take(core_.on_upstream_lost(goodbyes[0], now_s_));
    EXPECT_TRUE(wants<GiveUp>());
}

}  // namespace
}  // namespace lumenfarm::relay
