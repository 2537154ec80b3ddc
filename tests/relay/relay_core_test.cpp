#include "relay/relay_core.h"

#include "common/scene/scene_file.h"
#include "relay/prepare_lent.h"
#include "tests/simulation/fake_tracer.h"
#include "tests/simulation/small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace lumenfarm::relay {
namespace {

using ::lumenfarm::testing::FakeTracer;
using ::lumenfarm::testing::small_scene;

constexpr SessionId ann = 1, bob = 2;
constexpr std::uint64_t fingerprint = 7, own_instance = 99;

MasterPolicy farm_policy() {
    MasterPolicy farm;
    farm.fingerprint = fingerprint;
    farm.epoch = 3;
    farm.upstream = "the master";
    farm.instance = own_instance;
    return farm;
}

/// A relay that is welcome, and what it wants done. Files and preparation are answered at once.
class Relay : public ::testing::Test {
protected:
    Relay() : core_({"relay", own_instance, "", fingerprint}, farm_policy()) {
        take(core_.on_upstream_open(now_s_));
        above(wire::Welcome(5));
    }

    void above(wire::Message message) {
        effects_.clear();
        take(core_.on_upstream_message(std::move(message), now_s_));
    }
    void below(SessionId session, wire::Message message, std::uint64_t request = 0) {
        effects_.clear();
        take(core_.on_message(session, std::move(message), request, now_s_));
    }
    /// The connection to the master above is lost, and had again after so long.
    void reconnect(double after_s = 0) {
        take(core_.on_upstream_lost({}, now_s_));
        now_s_ += after_s;
        take(core_.on_upstream_open(now_s_));
        above(wire::Welcome(6));
    }
    void tick() {
        effects_.clear();
        take(core_.tick(now_s_));
    }
    void join(SessionId session, std::uint64_t instance, std::uint32_t threads = 1) {
        leases_[session] = 0;
        take(core_.on_connect(session, "10.0.0.1:1", now_s_));
        wire::Hello hello(wire::Role::worker, "w" + std::to_string(instance), instance);
        hello.threads = threads;
        hello.fingerprint = fingerprint;
        below(session, hello);
        take(core_.on_message(session, wire::Progress(0, {}), 0, now_s_));
    }
    /// The master above tells of a job, whose scene is fetched.
    void open_job(Packing packing = Packing::records, JobId id = 1) {
        JobSpec spec;
        spec.particles = 100'000;
        spec.particles_per_set = 1'000;
        spec.packing = packing;
        const Digest scene = scene_digest(bytes_);
        above(wire::JobInfo(id, scene, bytes_.size(), spec, 0.1, 2));
        if (!sent_up<wire::ManifestRequest>()) return;
        above(wire::Manifest(wire::FileManifest(scene, bytes_.size(), chunk_digests(bytes_))));
        above(wire::Chunk(scene, 0, bytes_));
    }
    void lease(std::uint64_t number, std::uint64_t first, std::uint64_t count, JobId job = 1) {
        above(wire::Lease(number, 1, job, {0, first, count}, 0));
    }
    std::vector<wire::Lease> pull(SessionId session, std::uint32_t sets) {
        below(session, wire::Pull(sets, leases_[session]));
        return all_sent<wire::Lease>(session);
    }
    /// The worker's honest result of a set.
    std::optional<wire::Verdict> deliver(SessionId session, const wire::Lease& set, std::uint64_t number) {
        TracedHits hits;
        FakeTracer(scene_).trace({}, set.range, hits, nullptr);
        below(session, wire::ResultHits(wire::PartId(set.job, number, 0), set.range.source, hits.records, {}));
        below(session, wire::ResultDone(set.job, number, {wire::Claim(set.lease, set.epoch, set.range)}, 1,
                                        hits.balance, 0.1, 0.1));
        const auto acks = all_sent<wire::ResultAck>(session);
        return acks.empty() ? std::nullopt : std::optional(acks.front().verdict);
    }
    /// The results that are handed up now.
    std::vector<wire::ResultDone> handed_up() {
        std::vector<wire::ResultDone> results;
        while (const auto part = core_.next_bulk())
            if (const auto* done = std::get_if<wire::ResultDone>(&*part)) results.push_back(*done);
        return results;
    }

    void take(Effects effects) {
        for (Effect& effect : effects) {
            const auto kept = std::get_if<KeepFile>(&effect);
            const auto prepare = std::get_if<PrepareLent>(&effect);
            if (kept) {
                files_[kept->file] = *kept->bytes;
                ++kept_;
                take(core_.on_file_kept(kept->file, {}, now_s_));
            } else if (prepare) {
                const auto read = [&](const Digest& file) -> Result<std::vector<std::byte>> { return files_.at(file); };
                take(core_.on_prepared(prepare->info, prepare_lent(*prepare, read), now_s_));
            } else {
                if (const auto* send = std::get_if<Send>(&effect))
                    leases_[send->session] += std::holds_alternative<wire::Lease>(send->message);
                effects_.push_back(std::move(effect));
            }
        }
        EXPECT_EQ(core_.contradiction(), std::nullopt);
    }
    template <class M>
    std::optional<M> sent_up() const {
        for (const Effect& effect : effects_)
            if (const auto* send = std::get_if<SendUp>(&effect))
                if (const auto* message = std::get_if<M>(&send->message)) return *message;
        return std::nullopt;
    }
    template <class M>
    std::vector<M> all_sent(SessionId session) const {
        std::vector<M> all;
        for (const Effect& effect : effects_)
            if (const auto* send = std::get_if<Send>(&effect); send && send->session == session)
                if (const auto* message = std::get_if<M>(&send->message)) all.push_back(*message);
        return all;
    }
    template <class E>
    bool wants() const {
        return std::any_of(effects_.begin(), effects_.end(),
                           [](const Effect& effect) { return std::holds_alternative<E>(effect); });
    }

    Scene scene_ = small_scene();
    std::vector<std::byte> bytes_ = encode_scene(scene_);
    RelayCore core_;
    Effects effects_;
    std::map<Digest, std::vector<std::byte>> files_;
    std::map<SessionId, std::uint64_t> leases_;  ///< sent in the session
    std::size_t kept_ = 0;
    double now_s_ = 0;
};

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
