#include "tests/master/master_fixture.h"

#include <gtest/gtest.h>

#include <functional>
#include <utility>

namespace lumenfarm::testing {
namespace {

TEST_F(MasterTest, WorkerIsWelcomeAndLearnsTheJobOnceBeforeItsLeases) {
    submit(records_job(), 1);
    greet(ann, 11);
    EXPECT_TRUE(sent<wire::Welcome>(ann));
    take(master_.on_message(ann, wire::Progress(), 0, now_s_));
    EXPECT_EQ(pull(ann, 2).size(), 2u);
    EXPECT_EQ(all_sent<wire::JobInfo>(ann).size(), 1u);
    EXPECT_EQ(sent<wire::JobInfo>(ann)->spec.packing, Packing::records);
    EXPECT_EQ(pull(ann, 1).size(), 1u);
    EXPECT_TRUE(all_sent<wire::JobInfo>(ann).empty());
}

TEST_F(MasterTest, OtherFingerprintIsToldWhyAndSentOff) {
    greet(ann, 11, fingerprint + 1);
    ASSERT_TRUE(sent<wire::Goodbye>(ann));
    EXPECT_EQ(sent<wire::Goodbye>(ann)->reason, wire::GoodbyeReason::refused);
    EXPECT_TRUE(find<Close>());
    EXPECT_EQ(master_.discarded(Discard::fingerprint_differs), 1u);
}

TEST_F(MasterTest, MessagesOutOfPlaceEndTheSession) {
    take(master_.on_connect(ann, "", now_s_));
    take(master_.on_message(ann, wire::Pull(1), 0, now_s_));
    EXPECT_EQ(sent<wire::Goodbye>(ann)->reason, wire::GoodbyeReason::protocol_error);
    join(bob, 12);
    take(master_.on_message(bob, wire::ControlRequest(1, wire::JobAction::cancel), 5, now_s_));
    EXPECT_EQ(sent<wire::Goodbye>(bob)->reason, wire::GoodbyeReason::protocol_error);
    EXPECT_EQ(master_.discarded(Discard::protocol_error), 2u);
}

/// What a worker asks for crosses what it is being sent.
TEST_F(MasterTest, LeasesOnTheirWayCountForAPull) {
    submit(records_job(), 1);
    join(ann, 11);
    EXPECT_EQ(pull(ann, 2).size(), 2u);
    take(master_.on_message(ann, wire::Pull(3, 0), 0, now_s_));
    EXPECT_EQ(all_sent<wire::Lease>(ann).size(), 1u) << "two are on their way";
    take(master_.on_message(ann, wire::Pull(1, 1), 0, now_s_));
    EXPECT_TRUE(all_sent<wire::Lease>(ann).empty());
    take(master_.on_message(ann, wire::Pull(1, 3), 0, now_s_));
    EXPECT_EQ(all_sent<wire::Lease>(ann).size(), 1u);
    take(master_.on_message(ann, wire::Pull(1, 1'000), 0, now_s_));
    EXPECT_EQ(all_sent<wire::Lease>(ann).size(), 1u) << "more than were sent";
}

TEST_F(MasterTest, JobRunsToItsEndAndIsDoneWhenItIsStored) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    std::uint64_t number = 0;
    for (auto leases = pull(ann, 1); !leases.empty(); leases = pull(ann, 1))
        EXPECT_EQ(deliver(ann, trace(leases[0], ++number)), wire::Verdict::accepted);
    EXPECT_EQ(master_.status(job, now_s_)->state, wire::JobState::running);
    // the last result brought the solution; the Pull after it brought nothing
    EXPECT_EQ(master_.status(job, now_s_)->committed, 10'000u);
    store_solution();
    EXPECT_EQ(master_.status(job, now_s_)->state, wire::JobState::done);
    EXPECT_TRUE(master_.record(job)->complete);
}

TEST_F(MasterTest, LastResultGivesTheSolutionAndTellsTheWorkers) {
    JobSpec spec = records_job();
    spec.particles_per_set = 1'000'000;
    submit(spec, 1);
    join(ann, 11);
    const auto leases = pull(ann, 4);
    ASSERT_EQ(leases.size(), 2u) << "one for each light";
    deliver(ann, trace(leases[0], 1));
    EXPECT_FALSE(find<StoreSolution>());
    deliver(ann, trace(leases[1], 2));
    ASSERT_TRUE(find<StoreSolution>());
    EXPECT_TRUE(find<StoreSolution>()->record.complete);
    EXPECT_TRUE(sent<wire::JobGone>(ann));
    EXPECT_EQ(deliver(ann, trace(leases[1], 3)), wire::Verdict::job_gone);
}

TEST_F(MasterTest, RepeatedResultIsMergedOnce) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 1);
    EXPECT_EQ(deliver(ann, trace(leases[0], 1)), wire::Verdict::accepted);
    const auto hits = master_.status(job, now_s_)->hits;
    EXPECT_EQ(deliver(ann, trace(leases[0], 2)), wire::Verdict::already_merged);
    EXPECT_EQ(master_.status(job, now_s_)->hits, hits);
    EXPECT_EQ(master_.discarded(Discard::result_repeated), 1u);
}

TEST_F(MasterTest, ResultOfAnotherEpochThanItsLeaseIsStale) {
    submit(records_job(), 1);
    join(ann, 11);
    auto lease = pull(ann, 1)[0];
    lease.epoch += 1;
    EXPECT_EQ(deliver(ann, trace(lease, 1)), wire::Verdict::stale);
}

TEST_F(MasterTest, LostWorkersSetIsGivenAgainAfterTheGraceAndItsResultIsStale) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    take(master_.on_disconnect(ann, now_s_));
    now_s_ = limits::reconnect_seconds + 1;
    take(master_.tick(now_s_));
    EXPECT_EQ(master_.status(job, now_s_)->leased, 0u);
    EXPECT_EQ(master_.discarded(Discard::lease_expired), 1u);
    join(ann, 11, {wire::LeaseProgress(lease.job, lease.lease, 0)});
    EXPECT_EQ(deliver(ann, trace(lease, 1)), wire::Verdict::stale);
    EXPECT_EQ(master_.status(job, now_s_)->results_stale, 1u);
}

TEST_F(MasterTest, WorkerThatComesBackGoesOnWithTheLeasesItStates) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    take(master_.on_disconnect(ann, now_s_));
    now_s_ = limits::reconnect_seconds / 2;
    join(bob, 11, {wire::LeaseProgress(leases[0].job, leases[0].lease, 0)});
    EXPECT_EQ(master_.status(job, now_s_)->leased, 1'000u) << "the other lease was lost on the way";
    now_s_ = limits::reconnect_seconds * 2;
    take(master_.tick(now_s_));
    EXPECT_EQ(deliver(bob, trace(leases[0], 1)), wire::Verdict::accepted);
}

TEST_F(MasterTest, HeartbeatsKeepLeases) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    for (; now_s_ < 3 * limits::lease_seconds; now_s_ += 5) {
        take(master_.on_message(ann, wire::Heartbeat(1), 0, now_s_));
        take(master_.tick(now_s_));
    }
    EXPECT_EQ(deliver(ann, trace(lease, 1)), wire::Verdict::accepted);
}

TEST_F(MasterTest, LiarIsRefusedWithAReasonAndChangesNothing) {
    const JobId job = submit(records_job(), 1);
    using Lie = std::function<void(wire::ResultHits&, wire::ResultDone&)>;
    const std::vector<std::pair<const char*, Lie>> lies = {
        {"triangle", [](auto& hits, auto&) { hits.records[0].triangle = 4; }},
        {"wavelength", [](auto& hits, auto&) { hits.records[0].wavelength = wavelength_bins; }},
        {"light", [](auto& hits, auto&) { hits.light ^= 1; }},
        {"no light", [](auto& hits, auto&) { hits.light = 2; }},
        {"energies", [](auto& hits, auto&) { hits.energies.assign(hits.records.size(), 1); }},
        {"sequence", [](auto& hits, auto&) { hits.part.sequence = 1; }},
        {"hit dropped", [](auto& hits, auto&) { hits.records.pop_back(); }},
        {"parts", [](auto&, auto& done) { done.parts = 2; }},
        {"balance", [](auto&, auto& done) { done.balance.absorbed += 1; }},
        {"batches", [](auto&, auto& done) { done.balance.emitted_by_batch[0] += 1; }},
        {"particles", [](auto&, auto& done) { done.balance.particles += 1; }},
        {"range", [](auto&, auto& done) { done.claims[0].range.first += 1; }},
        {"twice", [](auto&, auto& done) { done.claims.push_back(done.claims[0]); }},
    };
    std::uint64_t instance = 20;
    SessionId session = 20;
    for (const auto& [name, lie] : lies) {
        SCOPED_TRACE(name);
        join(++session, ++instance);
        auto result = trace(pull(session, 1)[0], 1);
        lie(result.first, result.second);
        EXPECT_EQ(deliver(session, result), wire::Verdict::invalid);
        EXPECT_FALSE(sent<wire::ResultAck>(session)->sentence.empty());
        EXPECT_EQ(master_.status(job, now_s_)->committed, 0u);
        EXPECT_EQ(master_.status(job, now_s_)->leased, 0u) << "what it held is given to others";
    }
    EXPECT_EQ(master_.discarded(Discard::result_invalid), lies.size());
    EXPECT_EQ(master_.staged_bytes(), 0u);
}

TEST_F(MasterTest, WhoLiesAgainAndAgainIsSentOff) {
    submit(records_job(), 1);
    join(ann, 11);
    for (std::uint64_t i = 1; i <= limits::invalid_results_max; ++i) {
        auto result = trace(pull(ann, 1)[0], i);
        result.second.balance.escaped += 1;
        deliver(ann, result);
    }
    EXPECT_EQ(sent<wire::Goodbye>(ann)->reason, wire::GoodbyeReason::refused);
    EXPECT_EQ(master_.discarded(Discard::lied), 1u);
    greet(bob, 11);
    EXPECT_EQ(sent<wire::Goodbye>(bob)->reason, wire::GoodbyeReason::refused) << "it is kept out";
    EXPECT_EQ(master_.discarded(Discard::quarantined), 1u);
}

TEST_F(MasterTest, HalfAResultIsForgottenWithItsConnection) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto result = trace(pull(ann, 1)[0], 1);
    take(master_.on_message(ann, result.first, 0, now_s_));
    EXPECT_GT(master_.staged_bytes(), 0u);
    take(master_.on_disconnect(ann, now_s_));
    EXPECT_EQ(master_.staged_bytes(), 0u);
}

TEST_F(MasterTest, OpenResultOfOneSessionIsBounded) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    wire::ResultHits part(wire::PartId(lease.job, 1, 0), lease.range.source, {}, {});
    part.records.assign(limits::hits_per_message_max, HitRecord{});
    for (; part.part.sequence < 400; ++part.part.sequence) {
        take(master_.on_message(ann, part, 0, now_s_));
        ASSERT_LE(master_.staged_bytes(), limits::staged_result_bytes_max);
    }
    EXPECT_GT(master_.discarded(Discard::staging_full), 0u);
    EXPECT_EQ(master_.staged_bytes(), 0u) << "nothing of it is kept";
}

TEST_F(MasterTest, ReturnedLeasesGoToOthersAndTheWorkerGetsNoMoreOfAJobItCantDo) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    take(master_.on_message(
        ann, wire::ReturnLeases(wire::ReturnReason::no_scene, {wire::LeaseRef(lease.lease, lease.epoch)}), 0, now_s_));
    EXPECT_TRUE(pull(ann, 1).empty());
    join(bob, 12);
    EXPECT_EQ(pull(bob, 1)[0].range, lease.range);
}

TEST_F(MasterTest, JobOfHigherPriorityGoesFirstAndTheNextBeginsWhenNothingIsLeft) {
    const JobId low = submit(records_job(), 1);
    JobSpec urgent = records_job();
    urgent.priority = 5;
    urgent.particles_per_set = 1'000'000;  // one set for each of the two lights
    const JobId high = submit(urgent, 2);
    const JobId later = submit(records_job(), 3);
    join(ann, 11);
    for (const auto& lease : pull(ann, 2)) EXPECT_EQ(lease.job, high);
    EXPECT_EQ(pull(ann, 1)[0].job, low);
    EXPECT_EQ(master_.status(later, now_s_)->state, wire::JobState::queued);
}

TEST_F(MasterTest, SameKeyIsTheSameJob) {
    const JobId job = submit(records_job(), 42);
    const wire::FileManifest manifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_));
    take(master_.on_message(embedding_session, wire::Submit(42, records_job(), manifest), 9, now_s_));
    EXPECT_EQ(sent<wire::SubmitReply>(embedding_session)->job, job);
    EXPECT_FALSE(find<Admit>());
}

TEST_F(MasterTest, SameKeyIsTheSameJobThoughTheFirstIsStillOnItsWay) {
    const wire::FileManifest manifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_));
    take(master_.on_message(embedding_session, wire::Submit(42, records_job(), manifest), 1, now_s_));
    const auto admit = find<Admit>();
    ASSERT_TRUE(admit);
    take(master_.on_message(embedding_session, wire::Submit(42, records_job(), manifest), 2, now_s_));
    take(master_.on_admitted(*admit, std::vector<std::uint32_t>{}, now_s_));
    const auto replies = all_sent<wire::SubmitReply>(embedding_session);
    ASSERT_EQ(replies.size(), 2u);
    EXPECT_EQ(replies[0].job, replies[1].job);
    EXPECT_FALSE(find<Admit>());
}

TEST_F(MasterTest, BadSpecsAndScenesAreRefusedWithTheirSentence) {
    JobSpec spec = records_job();
    spec.particles = 0;
    submit(spec, 1);
    EXPECT_EQ(sent<wire::Refusal>(embedding_session)->reason, wire::RefusalReason::bad_request);
    const wire::FileManifest manifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_));
    take(master_.on_message(embedding_session, wire::Submit(2, records_job(), manifest), 1, now_s_));
    take(master_.on_admitted(*find<Admit>(), bad_input("the scene has no light"), now_s_));
    EXPECT_EQ(sent<wire::Refusal>(embedding_session)->sentence, "the scene has no light");
    take(master_.on_message(embedding_session, wire::StatusRequest(), 1, now_s_));
    EXPECT_TRUE(sent<wire::StatusReply>(embedding_session)->jobs.empty());
}

TEST_F(MasterTest, CancelledJobTakesWhatIsOutstandingAndEnds) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    const auto leases = pull(ann, 2);
    take(master_.cancel(job, now_s_));
    EXPECT_EQ(sent<wire::Drain>(ann)->job, job);
    EXPECT_TRUE(pull(ann, 2).empty());
    ParticleRange part = leases[0].range;
    part.count = 400;
    EXPECT_EQ(deliver(ann, trace(leases[0], 1, part)), wire::Verdict::accepted);
    take(master_.on_message(ann,
                            wire::ReturnLeases(wire::ReturnReason::ending, {wire::LeaseRef(leases[0].lease, 1),
                                                                            wire::LeaseRef(leases[1].lease, 1)}),
                            0, now_s_));
    ASSERT_TRUE(find<StoreSolution>());
    EXPECT_EQ(find<StoreSolution>()->record.status.committed, 400u);
    store_solution();
    EXPECT_EQ(master_.status(job, now_s_)->state, wire::JobState::cancelled);
    take(master_.on_message(embedding_session, wire::FetchRequest(job), 3, now_s_));
    EXPECT_FALSE(sent<wire::FetchReply>(embedding_session)->complete);
}

TEST_F(MasterTest, CancelledJobWaitsForSilentWorkersOnlySoLong) {
    const JobId job = submit(records_job(), 1);
    join(ann, 11);
    pull(ann, 1);
    take(master_.cancel(job, now_s_));
    EXPECT_FALSE(find<StoreSolution>());
    take(master_.tick(limits::finish_seconds + 1));
    EXPECT_TRUE(find<StoreSolution>());
}

TEST_F(MasterTest, StoppedMasterSaysGoodbyeAndTakesNothing) {
    submit(records_job(), 1);
    join(ann, 11);
    take(master_.stop(now_s_));
    EXPECT_EQ(sent<wire::Goodbye>(ann)->reason, wire::GoodbyeReason::shutting_down);
    EXPECT_TRUE(find<Close>());
    EXPECT_EQ(submit(records_job(), 2), 0u);
}

}  // namespace
}  // namespace lumenfarm::testing
