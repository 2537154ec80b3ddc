#include "tests/master/master_fixture.h"

#include <gtest/gtest.h>

/// What the master refuses, closes and discards is counted by its reason, and said in the log.
namespace lumenfarm::testing {
namespace {

class CountingMaster : public MasterTest {
protected:
    std::vector<Discard> logged() const {
        std::vector<Discard> reasons;
        for (const Effect& effect : effects_)
            if (const auto* discarded = std::get_if<Discarded>(&effect)) reasons.push_back(discarded->reason);
        return reasons;
    }
    void hello(SessionId session, const wire::Hello& hello) {
        take(master_.on_connect(session, "10.0.0.1:1", now_s_));
        take(master_.on_message(session, hello, 0, now_s_));
    }
    static wire::Hello worker(std::uint64_t instance, std::uint32_t threads = 1) {
        wire::Hello hello(wire::Role::worker, "w", instance);
        hello.threads = threads;
        hello.fingerprint = fingerprint;
        return hello;
    }
};

TEST_F(CountingMaster, FarmsStatusHasEveryReasonAndThatOfAJobHasNone) {
    const JobId job = submit(records_job(), 1);
    net::Closed closed{net::CloseReason::protocol_error, wire::WireError::bad_magic, {}, "not ours"};
    master_.counts().count(closed);
    take(master_.on_message(embedding_session, wire::StatusRequest(), 2, now_s_));
    const auto farm = sent<wire::StatusReply>(embedding_session)->counts;
    EXPECT_EQ(farm, master_.counts().listed());
    const auto has = [&](const wire::ReasonCount& count) {
        return std::find(farm.begin(), farm.end(), count) != farm.end();
    };
    EXPECT_TRUE(has({"connections_closed", "protocol_error", 1}));
    EXPECT_TRUE(has({"frames_refused", "bad_magic", 1}));
    EXPECT_TRUE(has({"sent_off", "farm_full", 0}));
    take(master_.on_message(embedding_session, wire::StatusRequest(job), 3, now_s_));
    EXPECT_TRUE(sent<wire::StatusReply>(embedding_session)->counts.empty());
}

TEST_F(CountingMaster, RefusedRequestsAlsoThoseThatTheStorageRefuses) {
    take(master_.on_message(embedding_session, wire::StatusRequest(77), 1, now_s_));
    EXPECT_EQ(master_.counts().refused_requests.of(wire::RefusalReason::no_such_job), 1u);
    join(ann, 11);
    take(master_.on_message(ann, wire::ManifestRequest(Digest()), 5, now_s_));
    ASSERT_TRUE(find<ServeManifest>());
    take(master_.on_served(ann, wire::Refusal(wire::RefusalReason::no_such_file, "none"), 5, now_s_));
    EXPECT_TRUE(sent<wire::Refusal>(ann));
    EXPECT_EQ(master_.counts().refused_requests.of(wire::RefusalReason::no_such_file), 1u);
    take(master_.on_served(ann, wire::Chunk(Digest(), 0, {}), 6, now_s_));
    EXPECT_TRUE(sent<wire::Chunk>(ann));
}

TEST_F(CountingMaster, EveryWayToBeSentOff) {
    auto old = worker(1);
    old.protocol = wire::protocol_oldest - 1;
    hello(ann, old);
    EXPECT_EQ(logged(), std::vector{Discard::unsupported_protocol});
    hello(ann, worker(1, 0));
    EXPECT_EQ(logged(), std::vector{Discard::no_threads});
    hello(ann, worker(1));
    hello(bob, worker(1));
    EXPECT_EQ(logged(), std::vector{Discard::replaced});
    for (SessionId session = bob + 1; session < bob + limits::sessions_max; ++session)
        take(master_.on_connect(session, "10.0.0.1:1", now_s_));
    take(master_.on_connect(ann, "10.0.0.1:1", now_s_));
    EXPECT_EQ(logged(), std::vector{Discard::farm_full});
    for (const Discard reason :
         {Discard::unsupported_protocol, Discard::no_threads, Discard::replaced, Discard::farm_full})
        EXPECT_EQ(master_.discarded(reason), 1u) << name_of(reason);
}

TEST_F(CountingMaster, ResultsThatNeverBecomeWhole) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    take(master_.on_message(ann, trace(lease, 1).first, 0, now_s_));
    take(master_.on_message(ann, trace(lease, 2).first, 0, now_s_));
    EXPECT_EQ(master_.discarded(Discard::result_unfinished), 1u) << "another began";
    take(master_.on_disconnect(ann, now_s_));
    EXPECT_EQ(master_.discarded(Discard::result_unfinished), 2u) << "its connection was lost";
}

TEST_F(CountingMaster, ResultsThatComeTooLate) {
    submit(records_job(), 1);
    join(ann, 11);
    const auto lease = pull(ann, 1)[0];
    take(master_.on_disconnect(ann, now_s_));
    now_s_ = policy().reconnect_seconds + 1;
    take(master_.tick(now_s_));
    EXPECT_EQ(logged(), std::vector{Discard::lease_expired});
    join(ann, 11);
    EXPECT_EQ(deliver(ann, trace(lease, 1)), wire::Verdict::stale);
    EXPECT_EQ(master_.discarded(Discard::result_stale), 1u);
    auto gone = trace(lease, 2);
    gone.first.part.job = gone.second.job = 99;
    EXPECT_EQ(deliver(ann, gone), wire::Verdict::job_gone);
    EXPECT_EQ(master_.discarded(Discard::result_of_gone_job), 1u);
}

TEST_F(CountingMaster, LeasesThatAWorkerDoesNotKnowWhenItComesBack) {
    submit(records_job(), 1);
    join(ann, 11);
    pull(ann, 3);
    take(master_.on_disconnect(ann, now_s_));
    join(ann, 11);
    EXPECT_EQ(master_.discarded(Discard::lease_forgotten), 3u);
}

TEST_F(CountingMaster, WhatTheStorageFindsDamaged) {
    RecoveredJob recovered;
    recovered.damages = {"one", "two"};
    const wire::FileManifest manifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_));
    take(master_.on_message(embedding_session, wire::Submit(1, records_job(), manifest), 1, now_s_));
    take(master_.on_admitted(*find<Admit>(), std::vector<std::uint32_t>{}, now_s_));
    prepare(std::move(recovered));
    EXPECT_EQ(master_.discarded(Discard::stored_result_damaged), 2u);
    take(master_.on_discarded(Discard::chunk_refused, "it is damaged", now_s_));
    EXPECT_EQ(logged(), std::vector{Discard::chunk_refused});
    EXPECT_EQ(master_.discarded(Discard::chunk_refused), 1u);
}

TEST_F(CountingMaster, WelcomeNamesTheTimesOfTheFarmAndHowResultsTravel) {
    MasterPolicy patient = policy();
    patient.dead_seconds = 30;
    patient.reconnect_seconds = 120;
    patient.results_in_flight = 3;
    patient.compress = true;
    master_ = MasterCore(patient);
    hello(ann, worker(1));
    const auto welcome = sent<wire::Welcome>(ann);
    ASSERT_TRUE(welcome);
    EXPECT_EQ(welcome->dead_seconds, 30);
    EXPECT_EQ(welcome->heartbeat_seconds, 10);
    EXPECT_EQ(welcome->reconnect_seconds, 120);
    EXPECT_EQ(welcome->results_in_flight, 3u);
    EXPECT_TRUE(welcome->compress);
}

}  // namespace
}  // namespace lumenfarm::testing
