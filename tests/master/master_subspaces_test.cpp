#include "tests/master/master_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

/// Who gets which subspace, and what comes back. The light of the small scene is 0, its point light 1.
namespace lumenfarm::testing {
namespace {

class SubspacesOfMaster : public MasterTest {
protected:
    static constexpr std::uint32_t lights = 2;

    SubspacesOfMaster() {
        JobSpec spec = records_job();
        spec.strategy = Strategy::subspaces;
        spec.subspaces = 8;
        prepared_ = prepare_job(spec, bytes_).value();
        RecoveredJob recovered;
        const std::size_t subspaces = prepared_->sources() - lights;
        recovered.files.first = sha256({});
        recovered.files.first_bytes = 17;
        recovered.files.parts.assign(subspaces, PartFile{sha256({}), 1, 10});
        recovered.flights = queues_ = FlightQueues(subspaces);
        recovered.committed.resize(prepared_->sources());
        take(master_.on_message(
            embedding_session,
            wire::Submit(1, spec, wire::FileManifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_))), 1,
            now_s_));
        take(master_.on_admitted(find<Admit>().value(), std::vector<std::uint32_t>{}, now_s_));
        recovered.prepared = prepared_;
        take(master_.on_prepared(1, std::move(recovered), now_s_));
    }

    std::uint32_t subspaces() const { return static_cast<std::uint32_t>(queues_.subspaces()); }
    static wire::FlightRecord flight(std::uint32_t particle) {
        Flight flight;
        flight.origin = {0, 1, 0};
        flight.direction = {0, -1, 0};
        flight.particle = particle;
        flight.energy = flight.start_energy = 1'000;
        return wire::pack_flight(flight, 0);
    }
    /// A result of the lease in which everything that was emitted or came in is absorbed, but for `count` flights that
    /// go on in a subspace.
    wire::Verdict finish(SessionId session, const wire::Lease& lease, std::uint32_t subspace, std::uint32_t count,
                         std::int64_t missing_ticks = 0) {
        static std::uint64_t number = 0;
        ++number;
        EnergyBalance balance;
        if (lease.range.source < lights) {
            balance.particles = lease.range.count;
            for (std::uint64_t i = 0; i < lease.range.count; ++i)
                book_emission(balance, static_cast<std::uint32_t>(lease.range.first + i), 1'000);
            balance.particles = lease.range.count;
        }
        std::int64_t entered = 0;
        for (const wire::FlightRecord& each : lease.flights) entered += each.energy;
        balance.absorbed = balance.emitted + entered - 1'000 * std::int64_t{count} - missing_ticks;
        std::vector<wire::FlightRecord> leaving;
        for (std::uint32_t i = 0; i < count; ++i) leaving.push_back(flight(i));
        FlightQueues::Filed filed;
        if (count > 0) {
            take(master_.on_message(session, wire::ResultFlights({1, number, 0}, subspace, leaving), 0, now_s_));
            filed = {subspace, queues_.filed(subspace), std::make_shared<const FlightQueues::Flights>(leaving)};
        }
        disk_held_ = true;
        take(master_.on_message(session,
                                wire::ResultDone(1, number, {wire::Claim(lease.lease, lease.epoch, lease.range)},
                                                 count > 0 ? 1 : 0, balance, 0.1, 0.1),
                                0, now_s_));
        disk_held_ = false;
        if (const auto refused = sent<wire::ResultAck>(session)) return refused->verdict;
        if (count > 0) queues_.add(filed);
        Merged merged{100, {}};
        if (count > 0) merged.filed.push_back(filed);
        take(master_.on_results_stored(std::exchange(held_, {}), std::map<JobId, Merged>{{1, merged}}, now_s_));
        const auto ack = sent<wire::ResultAck>(session);
        return ack ? ack->verdict : wire::Verdict::invalid;
    }
    void has(SessionId session, std::vector<std::uint32_t> held, std::uint64_t room) {
        const bool all = held.size() == subspaces();
        take(master_.on_message(session, wire::PartsHeld(1, std::move(held), room, all), 0, now_s_));
    }
    wire::Lease pull_one(SessionId session) {
        const auto leases = pull(session, 1);
        EXPECT_EQ(leases.size(), 1u);
        return leases.empty() ? wire::Lease() : leases.front();
    }

    FlightQueues queues_;  ///< as the storage numbers them
};

TEST_F(SubspacesOfMaster, WorkerLearnsThePlanInPlaceOfTheScene) {
    join(ann, 11);
    EXPECT_LT(pull_one(ann).range.source, lights) << "nothing is in flight at first";
    ASSERT_TRUE(sent<wire::JobInfo>(ann));
    EXPECT_EQ(sent<wire::JobInfo>(ann)->scene, sha256({}));
    EXPECT_EQ(sent<wire::JobInfo>(ann)->scene_bytes, 17u);
}

TEST_F(SubspacesOfMaster, WhatLeavesIsLeasedWithItsParticles) {
    ASSERT_GE(subspaces(), 2u);
    join(ann, 11);
    EXPECT_EQ(finish(ann, pull_one(ann), 1, 300), wire::Verdict::accepted);
    has(ann, {0}, 10);
    const wire::Lease lease = pull_one(ann);
    EXPECT_EQ(lease.range, (ParticleRange{lights + 1, 0, 300}));
    ASSERT_EQ(lease.flights.size(), 300u);
    EXPECT_EQ(lease.flights[7], flight(7));
    EXPECT_EQ(finish(ann, lease, 0, 0), wire::Verdict::accepted);
}

TEST_F(SubspacesOfMaster, BalanceThatDoesNotCloseWithTheFlightsIsImpossible) {
    join(ann, 11);
    EXPECT_EQ(finish(ann, pull_one(ann), 1, 300), wire::Verdict::accepted);
    has(ann, {1}, 0);
    const wire::Lease light = pull_one(ann);
    EXPECT_EQ(finish(ann, light, 1, 10, 1), wire::Verdict::invalid);
}

TEST_F(SubspacesOfMaster, WorkerGetsWhatItHasThenWhatItHasRoomFor) {
    ASSERT_GE(subspaces(), 3u);
    join(ann, 11);
    EXPECT_EQ(finish(ann, pull_one(ann), 0, 1'000), wire::Verdict::accepted);
    EXPECT_EQ(finish(ann, pull_one(ann), 1, 900), wire::Verdict::accepted);
    EXPECT_EQ(finish(ann, pull_one(ann), 2, 950), wire::Verdict::accepted);
    has(ann, {0}, 9);
    EXPECT_EQ(pull_one(ann).range.source, lights + 0);
    EXPECT_LT(pull_one(ann).range.source, lights) << "there is no room for 10 triangles more";
    has(ann, {0}, 10);
    EXPECT_EQ(pull_one(ann).range.source, lights + 2) << "the fullest";
}

TEST_F(SubspacesOfMaster, CancelledJobEmitsNoMoreAndFollowsWhatIsInFlight) {
    join(ann, 11);
    const wire::Lease first = pull_one(ann);
    EXPECT_EQ(finish(ann, first, 1, 300), wire::Verdict::accepted);
    take(master_.cancel(1, now_s_));
    EXPECT_FALSE(find<StoreSolution>());
    EXPECT_NE(master_.status(1, now_s_)->sentence.find("follows 300 particles in flight"), std::string::npos)
        << master_.status(1, now_s_)->sentence;
    const wire::Lease rest = pull_one(ann);
    EXPECT_EQ(rest.range.source, lights + 1);
    EXPECT_TRUE(pull(ann, 1).empty());
    EXPECT_EQ(finish(ann, rest, 0, 0), wire::Verdict::accepted);
    const auto stored = find<StoreSolution>();
    ASSERT_TRUE(stored);
    EXPECT_FALSE(stored->record.flights_lost);
}

TEST_F(SubspacesOfMaster, CancelledJobThatNobodyFollowsEndsAndSaysWhatItLost) {
    join(ann, 11);
    EXPECT_EQ(finish(ann, pull_one(ann), 1, 300), wire::Verdict::accepted);
    take(master_.on_message(ann, wire::Goodbye(wire::GoodbyeReason::done), 0, now_s_));
    take(master_.cancel(1, now_s_));
    std::optional<StoreSolution> stored;
    for (double until_s = now_s_ + 3 * limits::finish_seconds; now_s_ < until_s && !stored; now_s_ += 1) {
        take(master_.tick(now_s_));
        stored = find<StoreSolution>();
    }
    ASSERT_TRUE(stored);
    EXPECT_TRUE(stored->record.flights_lost);
    EXPECT_FALSE(stored->record.complete);
}

}  // namespace
}  // namespace lumenfarm::testing
