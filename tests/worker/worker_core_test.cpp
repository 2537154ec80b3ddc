#include "tests/worker/worker_fixture.h"

#include <gtest/gtest.h>

#include <utility>

namespace lumenfarm::worker {
namespace {

TEST_F(WorkerTest, StatesItsLeasesAndPullsABacklogOfTwoSetsASlot) {
    take(core_.on_connect(now_s_));
    EXPECT_EQ(sent<wire::Hello>()->instance, 5u);
    hear(wire::Welcome(1));
    ASSERT_TRUE(sent<wire::Progress>());
    EXPECT_TRUE(sent<wire::Progress>()->leases.empty());
    EXPECT_EQ(sent<wire::Pull>()->sets, 4u);
}

TEST_F(WorkerTest, SetsWaitForTheirSceneAndThenFillTheSlots) {
    welcome();
    hear(info());
    EXPECT_TRUE(find<LoadScene>());
    for (std::uint64_t i = 1; i <= 4; ++i) hear(lease(i));
    EXPECT_TRUE(all<StartSlot>().empty());
    take(core_.on_scene_loaded(scene_digest(bytes_), std::make_shared<const std::vector<std::byte>>(bytes_), now_s_));
    prepare();
    EXPECT_EQ(all<StartSlot>().size(), 2u);
    finish_set(0, lease(1));
    EXPECT_EQ(all<StartSlot>().size(), 1u) << "the backlog feeds the slot at once";
    EXPECT_EQ(sent<wire::Pull>()->sets, 1u);
}

TEST_F(WorkerTest, MissingSceneIsFetchedVerifiedAndCached) {
    welcome();
    hear(info());
    take(core_.on_scene_loaded(scene_digest(bytes_), nullptr, now_s_));
    ASSERT_TRUE(sent<wire::ManifestRequest>());
    const Digest scene = scene_digest(bytes_);
    hear(wire::Manifest(wire::FileManifest(scene, bytes_.size(), chunk_digests(bytes_))));
    ASSERT_TRUE(sent<wire::ChunkRequest>());
    auto damaged = bytes_;
    damaged[10] ^= std::byte{1};
    hear(wire::Chunk(scene, 0, damaged));
    EXPECT_TRUE(sent<wire::ChunkRequest>()) << "a damaged chunk is asked for again";
    EXPECT_EQ(discarded(Discard::damaged_chunk), 1u);
    hear(wire::Chunk(scene, 3, bytes_));
    EXPECT_EQ(discarded(Discard::unexpected_message), 1u);
    hear(wire::Chunk(scene, 0, bytes_));
    EXPECT_TRUE(find<KeepScene>());
    EXPECT_TRUE(find<PrepareJob>());
}

TEST_F(WorkerTest, FetchGoesOnAfterAReconnect) {
    welcome();
    hear(info());
    take(core_.on_scene_loaded(scene_digest(bytes_), nullptr, now_s_));
    take(core_.on_disconnect(std::nullopt, now_s_));
    welcome();
    EXPECT_TRUE(sent<wire::ManifestRequest>());
}

/// The second job is prepared with the scene that the first one has fetched, and then hears that the cache lacks it.
TEST_F(WorkerTest, SceneIsNotFetchedForJobsThatHaveIt) {
    welcome();
    hear(info());
    take(core_.on_scene_loaded(scene_digest(bytes_), nullptr, now_s_));
    hear(wire::Manifest(wire::FileManifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_))));
    wire::JobInfo second = info();
    second.job = 2;
    hear(second);
    hear(wire::Chunk(scene_digest(bytes_), 0, bytes_));
    ASSERT_EQ(all<PrepareJob>().size(), 2u);
    take(core_.on_scene_loaded(scene_digest(bytes_), nullptr, now_s_));
    EXPECT_FALSE(sent<wire::ManifestRequest>()) << "both are being made";
}

/// The sums of a slot fit the context that they were begun with, and no other.
TEST_F(WorkerTest, JobIsPreparedOnce) {
    welcome();
    hear(info(Packing::maps));
    wire::JobInfo second = info(Packing::maps);
    second.job = 2;
    hear(second);
    EXPECT_FALSE(find<LoadScene>()) << "it is being loaded";
    const auto bytes = std::make_shared<const std::vector<std::byte>>(bytes_);
    take(core_.on_scene_loaded(scene_digest(bytes_), bytes, now_s_));
    EXPECT_EQ(all<PrepareJob>().size(), 2u);
    take(core_.on_scene_loaded(scene_digest(bytes_), bytes, now_s_));
    EXPECT_FALSE(find<PrepareJob>());

    const auto first = context(info(Packing::maps)), again = context(info(Packing::maps));
    take(core_.on_job_prepared(info(Packing::maps), first, now_s_));
    take(core_.on_job_prepared(info(Packing::maps), again, now_s_));
    take(core_.on_job_prepared(info(Packing::maps), failed("no memory"), now_s_));
    hear(lease(1));
    ASSERT_TRUE(find<StartSlot>());
    EXPECT_EQ(find<StartSlot>()->work.job, first);
}

TEST_F(WorkerTest, ContextOfAnotherSceneIsNotTheJobs) {
    welcome();
    hear(info());
    wire::JobInfo other = info();
    other.scene = sha256({});
    hear(other);
    take(core_.on_job_prepared(info(), context(info()), now_s_));
    hear(lease(1));
    EXPECT_FALSE(find<StartSlot>());
    take(core_.on_job_prepared(other, context(other), now_s_));
    EXPECT_TRUE(find<StartSlot>());
}

/// Chunks that were asked for in one go are refused one by one.
TEST_F(WorkerTest, RefusalOfAnotherFileIsNotThatOfThisScene) {
    welcome();
    hear(info());
    take(core_.on_scene_loaded(scene_digest(bytes_), nullptr, now_s_));
    hear(wire::Refusal(wire::RefusalReason::no_such_file, "gone", sha256({})));
    EXPECT_EQ(discarded(Discard::scene_not_fetched), 0u);
    EXPECT_EQ(discarded(Discard::unexpected_message), 1u);
    hear(wire::Refusal(wire::RefusalReason::no_such_file, "gone", scene_digest(bytes_)));
    EXPECT_EQ(discarded(Discard::scene_not_fetched), 1u);
}

/// The master does not say that they are gone when they ended meanwhile.
TEST_F(WorkerTest, JobsOfWhichNothingIsHeldAreForgottenWithTheSession) {
    welcome();
    ready();
    wire::JobInfo second = info();
    second.job = 2;
    hear(second);
    take(core_.on_job_prepared(second, context(second), now_s_));
    hear(lease(1));
    take(core_.on_disconnect(std::nullopt, now_s_));
    welcome();
    hear(lease(2, 1'000, 2));
    EXPECT_FALSE(find<StartSlot>()) << "job 2 has to be told of again";
    hear(lease(3));
    EXPECT_TRUE(find<StartSlot>()) << "job 1 is known";
}

TEST_F(WorkerTest, SceneThatStaysDamagedReturnsTheLeases) {
    welcome();
    hear(info());
    take(core_.on_scene_loaded(scene_digest(bytes_), nullptr, now_s_));
    hear(lease(1));
    const Digest scene = scene_digest(bytes_);
    hear(wire::Manifest(wire::FileManifest(scene, bytes_.size(), chunk_digests(bytes_))));
    auto damaged = bytes_;
    damaged[10] ^= std::byte{1};
    for (std::uint32_t i = 0; i < limits::chunk_attempts_max; ++i) hear(wire::Chunk(scene, 0, damaged));
    ASSERT_TRUE(sent<wire::ReturnLeases>());
    EXPECT_EQ(sent<wire::ReturnLeases>()->reason, wire::ReturnReason::no_scene);
    EXPECT_EQ(discarded(Discard::scene_not_fetched), 1u);
    EXPECT_EQ(discarded(Discard::set_not_traceable), 1u);
    hear(lease(2));
    EXPECT_TRUE(sent<wire::ReturnLeases>()) << "later ones too";
}

TEST_F(WorkerTest, ResultsAreKeptUntilAnsweredAndSentAgainAfterAReconnect) {
    welcome();
    ready();
    hear(lease(1));
    finish_set(0, lease(1));
    ASSERT_EQ(pump().size(), 1u);
    EXPECT_TRUE(pump().empty());
    take(core_.on_disconnect(std::nullopt, now_s_));
    EXPECT_EQ(core_.results_held(), 1u);
    welcome();
    ASSERT_EQ(sent<wire::Progress>()->leases.size(), 1u) << "the lease is stated";
    EXPECT_EQ(sent<wire::Progress>()->leases[0].job, 1u);
    EXPECT_TRUE(pump().empty()) << "the master may have to read the job from its disk first";
    hear(info(Packing::records));
    EXPECT_FALSE(find<LoadScene>()) << "it is the same job";
    const auto again = pump();
    ASSERT_EQ(again.size(), 1u);
    hear(wire::ResultAck(1, again[0].result, wire::Verdict::accepted));
    EXPECT_EQ(core_.results_held(), 0u);
    EXPECT_EQ(core_.particles_merged(), 1'000u);
}

TEST_F(WorkerTest, RefusedResultIsForgotten) {
    welcome();
    ready();
    hear(lease(1));
    finish_set(0, lease(1));
    const auto done = pump();
    hear(wire::ResultAck(1, done[0].result, wire::Verdict::stale, "late"));
    EXPECT_EQ(core_.results_held(), 0u);
    ASSERT_TRUE(find<Discarded>());
    EXPECT_EQ(find<Discarded>()->sentence, "stale: late");
    EXPECT_EQ(discarded(Discard::result_refused), 1u);
    EXPECT_EQ(core_.counts().verdicts.of(wire::Verdict::stale), 1u);
    hear(wire::ResultAck(1, done[0].result, wire::Verdict::stale, "late"));
    EXPECT_EQ(discarded(Discard::unexpected_message), 1u) << "it is forgotten";
    EXPECT_EQ(core_.particles_merged(), 0u);
}

/// A result of maps that is refused ends a lease in the midst of a set. Were the set gone on with, the next result
/// would be refused because of it, and end the next lease in the midst of its set, for ever.
TEST_F(WorkerTest, SlotsLeaveWhatTheyTraceOfARefusedLease) {
    welcome();
    ready(Packing::maps);
    hear(lease(1, 100'000));
    hear(lease(2, 100'000));
    hear(lease(3, 100'000));
    SlotReport closed;
    closed.set_left = true;
    closed.result = parcel(lease(1, 100'000), 2'048);
    take(core_.on_slot(0, std::move(closed), now_s_));
    ASSERT_EQ(all<ContinueSlot>().size(), 1u);
    const auto done = pump();
    ASSERT_EQ(done.size(), 1u);
    hear(wire::ResultAck(1, done[0].result, wire::Verdict::stale, "expired"));
    ASSERT_EQ(all<InterruptSlot>().size(), 1u) << "the other slot goes on";
    EXPECT_EQ(find<InterruptSlot>()->slot, 0u);
    EXPECT_EQ(find<InterruptSlot>()->ask, SlotAsk::abandon);
    ASSERT_TRUE(sent<wire::ReturnLeases>());
    EXPECT_EQ(sent<wire::ReturnLeases>()->leases, (std::vector<wire::LeaseRef>{{1, 1}}));
    take(core_.on_slot(0, SlotReport{}, now_s_));
    ASSERT_EQ(all<StartSlot>().size(), 1u);
    EXPECT_EQ(find<StartSlot>()->work.lease, 3u);
}

TEST_F(WorkerTest, LeftLeasesAreNotStatedAfterAReconnect) {
    welcome();
    ready(Packing::maps);
    hear(lease(1, 100'000));
    SlotReport closed;
    closed.set_left = true;
    closed.result = parcel(lease(1, 100'000), 2'048);
    take(core_.on_slot(0, std::move(closed), now_s_));
    const auto done = pump();
    ASSERT_EQ(done.size(), 1u);
    hear(wire::ResultAck(1, done[0].result, wire::Verdict::stale, "expired"));
    take(core_.on_disconnect(std::nullopt, now_s_));
    take(core_.on_connect(now_s_));
    hear(wire::Welcome(1));
    EXPECT_TRUE(sent<wire::Progress>()->leases.empty()) << "its slot still traces the last slice";
}

TEST_F(WorkerTest, ReturnsThatWaitForAResultOutliveAReconnect) {
    welcome();
    ready(Packing::maps);
    hear(lease(1, 100'000));
    for (int i = 0; i < 2; ++i) {
        SlotReport closed;
        closed.set_left = true;
        closed.result = parcel(lease(1, 100'000), 2'048);
        take(core_.on_slot(0, std::move(closed), now_s_));
    }
    const auto before = pump();
    ASSERT_EQ(before.size(), 2u);
    hear(wire::ResultAck(1, before[0].result, wire::Verdict::stale, "expired"));
    EXPECT_FALSE(sent<wire::ReturnLeases>()) << "the second result claims the lease";
    take(core_.on_slot(0, SlotReport{}, now_s_));
    take(core_.on_disconnect(std::nullopt, now_s_));
    take(core_.on_connect(now_s_));
    hear(wire::Welcome(1));
    EXPECT_EQ(sent<wire::Progress>()->leases.size(), 1u);
    hear(info(Packing::maps));
    const auto again = pump();
    ASSERT_EQ(again.size(), 1u);
    hear(wire::ResultAck(1, again[0].result, wire::Verdict::accepted));
    ASSERT_TRUE(sent<wire::ReturnLeases>()) << "nobody would trace the rest of it";
    EXPECT_EQ(sent<wire::ReturnLeases>()->leases, (std::vector<wire::LeaseRef>{{1, 1}}));
}

/// A new life of the master may have forgotten that an earlier one took the lease back, and wait for the rest of it.
TEST_F(WorkerTest, LeasesOfRefusedResultsAreReturnedThoughNoSlotHasThem) {
    welcome();
    ready();
    hear(lease(1));
    finish_set(0, lease(1));
    const auto done = pump();
    ASSERT_EQ(done.size(), 1u);
    hear(wire::ResultAck(1, done[0].result, wire::Verdict::stale, "expired"));
    ASSERT_TRUE(sent<wire::ReturnLeases>());
    EXPECT_EQ(sent<wire::ReturnLeases>()->leases, (std::vector<wire::LeaseRef>{{1, 1}}));
}

TEST_F(WorkerTest, CreditBoundsWhatIsUnderWayAndASlowMasterSlowsTheSlots) {
    welcome();
    ready();
    std::uint64_t number = 0;
    for (; number < 200; ++number) {
        hear(lease(number + 1));
        const auto start = find<StartSlot>();
        if (!start) break;
        finish_set(start->slot, lease(number + 1));
    }
    EXPECT_LE(core_.results_held(), 2 + limits::results_in_flight);
    EXPECT_LT(number, 200u) << "no more sets are begun";
    EXPECT_EQ(pump().size(), limits::results_in_flight);
}

TEST_F(WorkerTest, CreditIsWhatTheMasterSays) {
    take(core_.on_connect(now_s_));
    wire::Welcome welcome(1);
    welcome.results_in_flight = 2;
    hear(welcome);
    ready();
    for (std::uint64_t number = 1; number <= 6; ++number) {
        hear(lease(number));
        if (const auto start = find<StartSlot>()) finish_set(start->slot, lease(number));
    }
    EXPECT_EQ(core_.results_held(), 4u) << "two slots, and two under way";
    EXPECT_EQ(pump().size(), 2u);
    take(core_.on_disconnect({}, now_s_));
    take(core_.on_connect(now_s_));
    welcome.results_in_flight = 1;
    hear(welcome);
    EXPECT_EQ(core_.contradiction(), std::nullopt);
}

TEST_F(WorkerTest, MapsAreHandedOverWhenLateOrIdle) {
    welcome();
    ready(Packing::maps);
    hear(lease(1));
    hear(lease(2));
    hear(lease(3));
    SlotReport open;
    open.set_finished = open.open = true;
    now_s_ = limits::first_flush_seconds / 2;
    take(core_.on_slot(0, open, now_s_));
    ASSERT_EQ(all<StartSlot>().size(), 1u) << "the sums stay open for the next set";
    now_s_ = limits::first_flush_seconds;
    take(core_.tick(now_s_));
    EXPECT_EQ(all<InterruptSlot>().size(), 2u) << "the first result comes soon";
    take(core_.on_slot(1, open, now_s_));
    ASSERT_TRUE(find<TellSlot>()) << "nothing is left to trace";
    EXPECT_EQ(find<TellSlot>()->ask, SlotAsk::close);
}

TEST_F(WorkerTest, LaterMapsWaitForTheFlushSeconds) {
    welcome();
    ready(Packing::maps);
    hear(lease(1));
    finish_set(0, lease(1));
    hear(lease(2));
    now_s_ = 1.9;
    take(core_.tick(now_s_));
    EXPECT_TRUE(all<InterruptSlot>().empty());
    now_s_ = 2;
    take(core_.tick(now_s_));
    EXPECT_EQ(all<InterruptSlot>().size(), 1u);
}

TEST_F(WorkerTest, ASetApartHasAResultOfItsOwn) {
    welcome();
    ready(Packing::maps);
    wire::Lease apart = lease(3);
    apart.apart = true;
    for (const wire::Lease& each : {lease(1), lease(2), apart, lease(4)}) hear(each);
    SlotReport open;
    open.set_finished = open.open = true;
    take(core_.on_slot(0, open, now_s_));
    EXPECT_EQ(find<StartSlot>()->work.lease, 4u) << "what may go along comes first";
    take(core_.on_slot(0, open, now_s_));
    ASSERT_TRUE(find<TellSlot>());
    EXPECT_EQ(find<TellSlot>()->ask, SlotAsk::close);
    SlotReport closed;
    closed.result = parcel(lease(1), 1'000);
    take(core_.on_slot(0, closed, now_s_));
    EXPECT_EQ(find<StartSlot>()->work.lease, 3u);
    hear(lease(5));
    take(core_.on_slot(0, open, now_s_));
    ASSERT_TRUE(find<TellSlot>()) << "nothing goes along with it";
}

TEST_F(WorkerTest, APullSaysWhatHasCome) {
    welcome();
    ready(Packing::records);
    hear(lease(1));
    hear(lease(2));
    finish_set(0, lease(1));
    EXPECT_EQ(sent<wire::Pull>(), wire::Pull(3, 2));
    take(core_.on_disconnect(std::nullopt, now_s_));
    welcome();
    finish_set(1, lease(2));
    EXPECT_EQ(sent<wire::Pull>(), wire::Pull(4, 0));
}

/// Sets of one slice end before they hear of it; were that forgotten, their sums would stay open for ever.
TEST_F(WorkerTest, LateMapsAreHandedOverThoughTheSetEndsBeforeTheInterrupt) {
    welcome();
    ready(Packing::maps);
    hear(lease(1));
    hear(lease(2));
    hear(lease(3));
    now_s_ = 2;
    take(core_.tick(now_s_));
    EXPECT_EQ(all<InterruptSlot>().size(), 2u);
    now_s_ = 2.1;
    take(core_.tick(now_s_));
    EXPECT_TRUE(all<InterruptSlot>().empty()) << "asked once";
    SlotReport open;
    open.set_finished = open.open = true;
    take(core_.on_slot(0, open, now_s_));
    ASSERT_TRUE(find<TellSlot>());
    EXPECT_EQ(find<TellSlot>()->ask, SlotAsk::close);
}

TEST_F(WorkerTest, GoneJobIsDroppedWithItsSetsSumsAndResults) {
    welcome();
    ready();
    for (std::uint64_t i = 1; i <= 4; ++i) hear(lease(i));
    finish_set(0, lease(1));
    hear(wire::JobGone(1));
    EXPECT_EQ(discarded(Discard::set_of_gone_job), 3u);
    EXPECT_EQ(discarded(Discard::result_of_gone_job), 3u) << "one is closed, two are open";
    EXPECT_EQ(core_.results_held(), 0u);
    EXPECT_EQ(all<InterruptSlot>().size(), 2u);
    take(core_.on_slot(0, SlotReport{}, now_s_));
    take(core_.on_slot(1, SlotReport{}, now_s_));
    EXPECT_TRUE(all<StartSlot>().empty());
    EXPECT_EQ(core_.results_held(), 0u);
}

TEST_F(WorkerTest, RefusedWorkerGivesUpAndAStoppedMasterIsWaitedFor) {
    welcome();
    take(core_.on_disconnect(wire::Goodbye(wire::GoodbyeReason::shutting_down, "bye"), now_s_));
    EXPECT_FALSE(find<GiveUp>());
    take(core_.on_disconnect(wire::Goodbye(wire::GoodbyeReason::refused, "other bits"), now_s_));
    ASSERT_TRUE(find<GiveUp>());
    EXPECT_NE(find<GiveUp>()->sentence.find("other bits"), std::string::npos);
}

TEST_F(WorkerTest, SetsThatWaitedForTooLongAreForgotten) {
    take(core_.on_connect(now_s_));
    wire::Welcome impatient(1);
    impatient.reconnect_seconds = 2;
    hear(impatient);
    for (std::uint64_t i = 1; i <= 4; ++i) hear(lease(i));
    take(core_.on_disconnect(std::nullopt, now_s_));
    now_s_ = 1.5;
    hear(impatient);
    EXPECT_EQ(sent<wire::Progress>()->leases.size(), 4u);
    take(core_.on_disconnect(std::nullopt, now_s_));
    now_s_ = 4;
    hear(impatient);
    EXPECT_TRUE(sent<wire::Progress>()->leases.empty());
    EXPECT_EQ(discarded(Discard::set_outlived), 4u);
}

/// One result at a time is sent, though an older one becomes due while a younger one is under way.
TEST_F(WorkerTest, PartsOfTwoResultsAreNotMixed) {
    welcome();
    ready();
    hear(lease(1));
    SlotReport report;
    report.set_finished = true;
    report.result = parcel(lease(1), 1'000);
    report.result->hits = {{0, std::vector<HitRecord>(3 * limits::hits_per_message_max), {}}};
    take(core_.on_slot(0, std::move(report), now_s_));
    take(core_.on_disconnect(std::nullopt, now_s_));
    // a result of another job comes behind it, whose job the master knows first
    wire::JobInfo other = info();
    other.job = 2;
    take(core_.on_connect(now_s_));
    hear(wire::Welcome(2));
    hear(other);
    take(core_.on_scene_loaded(scene_digest(bytes_), std::make_shared<const std::vector<std::byte>>(bytes_), now_s_));
    take(core_.on_job_prepared(other, context(other), now_s_));
    const wire::Lease second = lease(2, 1'000, 2);
    hear(second);
    SlotReport later;
    later.set_finished = true;
    later.result = parcel(second, 1'000);
    later.result->hits = {{0, std::vector<HitRecord>(3 * limits::hits_per_message_max), {}}};
    take(core_.on_slot(0, std::move(later), now_s_));
    const auto number_of = [](const std::optional<wire::Message>& part) {
        const auto* hits = part ? std::get_if<wire::ResultHits>(&*part) : nullptr;
        return hits ? hits->part.result : 0;
    };
    EXPECT_EQ(number_of(core_.next_bulk()), 2u);
    hear(info());
    EXPECT_EQ(number_of(core_.next_bulk()), 2u);
    while (const auto part = core_.next_bulk())
        if (const auto* done = std::get_if<wire::ResultDone>(&*part)) {
            EXPECT_EQ(done->result, 2u);
            break;
        }
    EXPECT_EQ(number_of(core_.next_bulk()), 1u);
}

}  // namespace
}  // namespace lumenfarm::worker
