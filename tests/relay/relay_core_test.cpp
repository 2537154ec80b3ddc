#include "tests/relay/relay_fixture.h"

namespace lumenfarm::relay {
namespace {

TEST_F(Relay, SaysThatItIsOneAndPullsForTheThreadsOfItsWorkers) {
    EXPECT_FALSE(sent_up<wire::Pull>()) << "nobody is there";
    join(ann, 11, 3);
    EXPECT_EQ(sent_up<wire::Pull>(), wire::Pull(3, 0, 3, 1));
    join(bob, 12, 4);
    EXPECT_EQ(sent_up<wire::Pull>(), wire::Pull(limits::relay_sets_ahead, 0, 7, 2));
    effects_.clear();
    take(core_.on_disconnect(ann, now_s_));
    EXPECT_EQ(sent_up<wire::Pull>(), wire::Pull(limits::relay_sets_ahead, 0, 4, 1));
}

TEST_F(Relay, APullSaysWhatHasCome) {
    join(ann, 11);
    open_job();
    lease(1, 0, 1'000);
    effects_.clear();
    EXPECT_EQ(pull(ann, 1).size(), 1u);
    EXPECT_EQ(sent_up<wire::Pull>(), wire::Pull(1, 1, 1, 1)) << "nothing is ahead any more";
}

TEST_F(Relay, CutsALeaseForItsWorkersAndClaimsOfTheMastersLease) {
    join(ann, 11);
    join(bob, 12);
    open_job();
    lease(70, 5'000, 2'000);
    const auto first = pull(ann, 1), second = pull(bob, 1);
    ASSERT_EQ(first.size(), 1u);
    ASSERT_EQ(second.size(), 1u);
    EXPECT_EQ(first[0].range, (ParticleRange{0, 5'000, 1'000}));
    EXPECT_EQ(second[0].range, (ParticleRange{0, 6'000, 1'000}));
    EXPECT_NE(first[0].lease, 70u);
    EXPECT_EQ(deliver(bob, second[0], 4), wire::Verdict::accepted);
    const auto results = handed_up();
    ASSERT_EQ(results.size(), 1u) << "hits go up at once";
    EXPECT_EQ(results[0].claims, (std::vector{wire::Claim(70, 1, {0, 6'000, 1'000})}));
    EXPECT_EQ(results[0].balance.particles, 1'000u);
}

TEST_F(Relay, SumsWaitForTheFlushAndGoAtOnceWhenNothingIsLeft) {
    join(ann, 11);
    open_job(Packing::maps);
    lease(70, 0, 3'000);
    const auto sets = pull(ann, 3);
    ASSERT_EQ(sets.size(), 3u);
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::accepted);
    EXPECT_TRUE(handed_up().empty());
    now_s_ += 3;
    tick();
    EXPECT_EQ(handed_up().size(), 1u) << "the flush seconds are over";
    EXPECT_EQ(deliver(ann, sets[1], 2), wire::Verdict::accepted);
    EXPECT_TRUE(handed_up().empty());
    EXPECT_EQ(deliver(ann, sets[2], 3), wire::Verdict::accepted);
    const auto results = handed_up();
    ASSERT_EQ(results.size(), 1u);
    EXPECT_EQ(results[0].claims, (std::vector{wire::Claim(70, 1, {0, 1'000, 2'000})})) << "neighbours are one claim";
}

TEST_F(Relay, SumsDoNotWaitLongOnceTheWorkersHaveAllThatIsHere) {
    constexpr std::uint64_t early = limits::results_in_flight - 1;
    join(ann, 11);
    open_job(Packing::maps);
    lease(70, 0, (early + 3) * 1'000);
    const auto sets = pull(ann, early + 2);
    ASSERT_EQ(sets.size(), early + 2);
    for (std::uint64_t i = 0; i < early; ++i) {  // each may wait longer than the one before
        EXPECT_EQ(deliver(ann, sets[i], i), wire::Verdict::accepted);
        now_s_ += 3;
        tick();
        EXPECT_EQ(handed_up().size(), 1u);
    }
    EXPECT_EQ(deliver(ann, sets[early], early), wire::Verdict::accepted);
    now_s_ += 2 * limits::first_flush_seconds;
    tick();
    EXPECT_TRUE(handed_up().empty()) << "there is more to give out";
    EXPECT_EQ(pull(ann, 1).size(), 1u);
    EXPECT_EQ(handed_up().size(), 1u);
}

TEST_F(Relay, SetsThatWorkersWereLostWithGoBackAsLost) {
    join(bob, 99'000);
    open_job();
    lease(70, 0, 1'000);
    for (std::uint64_t instance = 11; instance < 11 + limits::losses_max; ++instance) {
        join(ann, instance);
        const auto sets = pull(ann, 1);
        ASSERT_EQ(sets.size(), 1u) << "worker " << instance;
        take(core_.on_disconnect(ann, now_s_));
        now_s_ += limits::reconnect_seconds + 1;
        tick();
        EXPECT_EQ(sent_up<wire::ReturnLeases>().has_value(), instance == 10 + limits::losses_max);
        now_s_ += 10;
    }
    const auto returned = sent_up<wire::ReturnLeases>();
    ASSERT_TRUE(returned);
    EXPECT_EQ(returned->reason, wire::ReturnReason::lost);
    EXPECT_EQ(returned->leases, (std::vector{wire::LeaseRef(70, 1)}));
}

TEST_F(Relay, JobThatNoWorkerCanTraceGoesBack) {
    join(ann, 11);
    open_job();
    lease(70, 0, 1'000);
    const auto sets = pull(ann, 1);
    ASSERT_EQ(sets.size(), 1u);
    below(ann, wire::ReturnLeases(wire::ReturnReason::tracer_failed, {wire::LeaseRef(sets[0].lease, sets[0].epoch)}));
    tick();
    const auto returned = sent_up<wire::ReturnLeases>();
    ASSERT_TRUE(returned);
    EXPECT_EQ(returned->reason, wire::ReturnReason::no_scene);
}

TEST_F(Relay, DrainedJobHandsUpWhatWorkersHaveAndReturnsTheRest) {
    join(ann, 11);
    open_job(Packing::maps);
    lease(70, 0, 5'000);
    const auto sets = pull(ann, 2);
    ASSERT_EQ(sets.size(), 2u);
    above(wire::Drain(1));
    EXPECT_FALSE(all_sent<wire::Drain>(ann).empty());
    EXPECT_FALSE(sent_up<wire::ReturnLeases>()) << "the worker has sets";
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::accepted);
    below(ann, wire::ReturnLeases(wire::ReturnReason::ending, {wire::LeaseRef(sets[1].lease, sets[1].epoch)}));
    const auto results = handed_up();
    ASSERT_EQ(results.size(), 1u);
    EXPECT_FALSE(sent_up<wire::ReturnLeases>()) << "a result claims of the lease";
    above(wire::ResultAck(1, results[0].result, wire::Verdict::accepted));
    EXPECT_TRUE(sent_up<wire::ReturnLeases>());
    EXPECT_TRUE(pull(ann, 1).empty());
    lease(71, 8'000, 1'000);
    EXPECT_FALSE(sent_up<wire::ReturnLeases>());
    EXPECT_EQ(all_sent<wire::Lease>(ann).size(), 1u) << "it goes on";
    EXPECT_EQ(all_sent<wire::JobInfo>(ann).size(), 1u) << "which the worker has to hear";
}

TEST_F(Relay, JobThatBecameAnotherGivesBackWhatResultsClaimToo) {
    join(ann, 11);
    open_job();
    lease(70, 0, 1'000);
    const auto sets = pull(ann, 1);
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::accepted);
    lease(71, 1'000, 1'000);
    JobSpec spec;
    spec.particles = 200'000;
    spec.packing = Packing::records;
    above(wire::JobInfo(1, scene_digest(bytes_), bytes_.size(), spec, 0.1, 2));
    const auto returned = sent_up<wire::ReturnLeases>();
    ASSERT_TRUE(returned);
    EXPECT_EQ(returned->leases.size(), 2u) << "one was claimed whole, and its result is dropped";
    EXPECT_TRUE(handed_up().empty());
}

TEST_F(Relay, WorkersWaitForTheirAnswersWhileTooMuchIsOnItsWay) {
    // the first result alone is more than a byte
    core_ = RelayCore({"relay", own_instance, "", fingerprint}, farm_policy(), limits::drain_seconds, 1);
    take(core_.on_upstream_open(now_s_));
    above(wire::Welcome(5));
    join(ann, 11);
    open_job();
    lease(70, 0, 3'000);
    const auto sets = pull(ann, 3);
    ASSERT_EQ(sets.size(), 3u);
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::accepted);
    EXPECT_EQ(deliver(ann, sets[1], 2), std::nullopt);
    const auto first = handed_up();
    ASSERT_EQ(first.size(), 1u);
    above(wire::ResultAck(1, first[0].result, wire::Verdict::accepted));
    EXPECT_EQ(all_sent<wire::ResultAck>(ann).size(), 1u) << "there is room again";
    EXPECT_EQ(deliver(ann, sets[2], 3), std::nullopt);
    above(wire::JobGone(1));
    EXPECT_EQ(all_sent<wire::JobGone>(ann).size(), 1u);
}

TEST_F(Relay, EndsWhenItHasHandedUpWhatItHad) {
    join(ann, 11);
    open_job();
    lease(70, 0, 2'000);
    const auto sets = pull(ann, 1);
    effects_.clear();
    take(core_.drain(now_s_));
    EXPECT_FALSE(all_sent<wire::Drain>(ann).empty());
    EXPECT_FALSE(wants<Finished>());
    lease(71, 5'000, 100);
    EXPECT_TRUE(sent_up<wire::ReturnLeases>()) << "it takes nothing more";
    EXPECT_EQ(deliver(ann, sets[0], 1), wire::Verdict::accepted);
    const auto results = handed_up();
    ASSERT_EQ(results.size(), 1u);
    EXPECT_FALSE(wants<Finished>()) << "the master has not answered";
    above(wire::ResultAck(1, results[0].result, wire::Verdict::accepted));
    EXPECT_TRUE(wants<Finished>());
}

TEST_F(Relay, FetchesAFileOnceForAllAndKeepsItWhileAJobNeedsIt) {
    join(ann, 11);
    join(bob, 12);
    const Digest scene = scene_digest(bytes_);
    JobSpec spec;
    spec.packing = Packing::records;
    above(wire::JobInfo(1, scene, bytes_.size(), spec, 0.1, 2));
    EXPECT_EQ(sent_up<wire::ManifestRequest>(), wire::ManifestRequest(scene));
    below(ann, wire::ManifestRequest(scene), 4);
    EXPECT_FALSE(sent_up<wire::ManifestRequest>()) << "it is on its way";
    EXPECT_FALSE(wants<ServeManifest>());
    above(wire::Manifest(wire::FileManifest(scene, bytes_.size(), chunk_digests(bytes_))));
    above(wire::Chunk(scene, 0, bytes_));
    EXPECT_TRUE(wants<ServeManifest>()) << "who has waited for it gets it";
    below(bob, wire::ManifestRequest(scene), 5);
    EXPECT_TRUE(wants<ServeManifest>());
    open_job(Packing::maps, 2);
    EXPECT_EQ(kept_, 1u) << "two jobs share it";
    above(wire::JobGone(1));
    EXPECT_FALSE(wants<RemoveFile>());
    above(wire::JobGone(2));
    EXPECT_TRUE(wants<RemoveFile>());
}

TEST_F(Relay, FileThatDoesNotComeIsRefusedToWhoWaits) {
    join(ann, 11);
    const Digest scene = scene_digest(bytes_);
    JobSpec spec;
    spec.packing = Packing::records;
    above(wire::JobInfo(1, scene, bytes_.size(), spec, 0.1, 2));
    lease(70, 0, 1'000);
    below(ann, wire::ManifestRequest(scene), 4);
    above(wire::Refusal(wire::RefusalReason::no_such_file, "it is gone", scene));
    EXPECT_EQ(all_sent<wire::Refusal>(ann).size(), 1u);
    const auto returned = sent_up<wire::ReturnLeases>();
    ASSERT_TRUE(returned);
    EXPECT_EQ(returned->reason, wire::ReturnReason::no_scene);
}

TEST_F(Relay, ImpossibleLeasesGoBack) {
    join(ann, 11);
    open_job();
    above(wire::Lease(70, 1, 1, {500, 0, 10}, 0));
    ASSERT_TRUE(sent_up<wire::ReturnLeases>());
    EXPECT_EQ(sent_up<wire::ReturnLeases>()->reason, wire::ReturnReason::tracer_failed);
    lease(71, limits::particles_max - 100, 50);
    EXPECT_TRUE(sent_up<wire::ReturnLeases>()) << "beyond the particles of the light";
    lease(72, 0, 100);
    EXPECT_FALSE(sent_up<wire::ReturnLeases>());
    lease(73, 50, 100);
    ASSERT_TRUE(sent_up<wire::ReturnLeases>());
    EXPECT_EQ(sent_up<wire::ReturnLeases>()->leases, (std::vector{wire::LeaseRef(72, 1)})) << "the master has ended it";
    lease(73, 900, 10);
    ASSERT_TRUE(sent_up<wire::ReturnLeases>()) << "a number is of one lease";
    wire::Lease audit(74, 1, 1, {0, 500, 10}, 0);
    audit.audit = 3;
    above(audit);
    EXPECT_TRUE(sent_up<wire::ReturnLeases>()) << "an audit is of one worker";
}

}  // namespace
}  // namespace lumenfarm::relay
