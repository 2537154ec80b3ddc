#include "proto/messages.h"

#include "common/spectrum/spectrum.h"
#include "tests/proto/sample_messages.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <numeric>
#include <set>

namespace lumenfarm::wire {
namespace {

std::span<const std::byte> payload_of(const std::vector<std::byte>& frame) {
    return std::span(frame).subspan(limits::frame_header_bytes);
}

Decoded<Message> there_and_back(const Message& message) {
    return decode(type_of(message), payload_of(encode(message)));
}

TEST(Messages, SamplesCoverEveryType) {
    std::set<MessageType> seen;
    for (const auto& message : test::sample_messages()) seen.insert(type_of(message));
    EXPECT_EQ(seen.size(), message_rules.size());
}

TEST(Messages, TypesAndNamesAreUnique) {
    std::set<MessageType> types;
    std::set<std::string_view> names;
    for (const auto& rule : message_rules) {
        EXPECT_TRUE(types.insert(rule.type).second) << rule.name;
        EXPECT_TRUE(names.insert(rule.name).second) << rule.name;
        EXPECT_NE(rule.senders, 0) << rule.name;
    }
}

TEST(Messages, EachComesBackEqual) {
    for (const auto& message : test::sample_messages()) {
        const auto back = there_and_back(message);
        ASSERT_TRUE(back.has_value()) << name_of(message) << ": " << name_of(back.error());
        EXPECT_EQ(*back, message) << name_of(message);
    }
}

TEST(Messages, EachIsRefusedWhenCutShortOrTooLong) {
    for (const auto& message : test::sample_messages()) {
        const auto frame = encode(message);
        const auto payload = payload_of(frame);
        for (std::size_t size = 0; size < payload.size(); ++size)
            EXPECT_FALSE(decode(type_of(message), payload.first(size)).has_value()) << name_of(message) << " " << size;
        std::vector<std::byte> longer(payload.begin(), payload.end());
        longer.push_back({});
        EXPECT_EQ(decode(type_of(message), longer).error(), WireError::trailing_bytes) << name_of(message);
    }
}

TEST(Messages, UnknownTypeIsRefused) { EXPECT_TRUE(decode(static_cast<MessageType>(77), {}).has_error()); }

/// The largest that each message can be: encode() checks the caps by itself.
TEST(Messages, LargestFitTheirCaps) {
    const std::string text(100'000, 'x');
    const PartId part(1, 1, 0);
    JobStatus job;
    job.name = job.sentence = text;
    job.eta_seconds = 1;
    job.digest = Digest();
    WorkerStatus worker;
    worker.name = worker.address = worker.isa = text;
    JobSpec spec = test::sample_spec();
    spec.name = text;
    Hello hello(Role::worker, text, 1);
    hello.isa = text;
    const FileManifest manifest(Digest(), limits::chunks_max * limits::chunk_bytes,
                                std::vector<Digest>(limits::chunks_max));
    const std::vector<LeaseRef> refs(limits::leases_per_worker_max, LeaseRef(1, 1));
    const std::vector<Claim> claims(limits::claims_per_result_max, Claim(1, 1, {0, 0, 1}));
    std::vector<std::uint32_t> chunks(limits::chunks_max);
    Lease largest_lease(1, 1, 1, {limits::lights_max, 0, limits::flights_per_message_max}, 1);
    largest_lease.flights.assign(limits::flights_per_message_max, test::sample_flight());
    std::vector<std::uint32_t> subspaces(limits::subspaces_max);
    std::iota(subspaces.begin(), subspaces.end(), 0u);
    std::vector<SubspaceWork> all_work;
    for (std::uint32_t subspace = 0; subspace < limits::subspaces_max; ++subspace)
        all_work.push_back({subspace, static_cast<std::uint32_t>(limits::hits_per_map_max), 1});
    const std::vector<Message> largest = {
        hello,
        Goodbye(GoodbyeReason::done, text),
        Refusal(RefusalReason::full, text),
        JobInfo(1, Digest(), 1, spec, 1, 1),
        ReturnLeases(ReturnReason::ending, refs),
        Progress(1, std::vector<LeaseProgress>(limits::leases_per_worker_max)),
        ResultHits(part, 0, std::vector<HitRecord>(limits::hits_per_message_max),
                   std::vector<std::uint32_t>(limits::hits_per_message_max)),
        ResultMap(part, std::vector<TexelDelta>(limits::texel_deltas_per_message_max),
                  std::vector<SurfaceDelta>(limits::surface_deltas_per_message_max)),
        ResultKept(part, std::vector<KeptHit>(limits::hits_per_message_max)),
        ResultFlights(part, 0, std::vector<FlightRecord>(limits::flights_per_message_max, test::sample_flight())),
        ResultWork(part, all_work),
        largest_lease,
        PartsHeld(1, subspaces, 1, false),
        ResultDone(1, 1, claims, 1, test::sample_balance(limits::claims_per_result_max), 1, 1),
        ResultAck(1, 1, Verdict::invalid, text),
        Manifest(manifest),
        Chunk(Digest(), 0, std::vector<std::byte>(limits::chunk_bytes)),
        SubmitReply(0, chunks),
        StatusReply(std::vector<JobStatus>(limits::jobs_listed_max, job),
                    std::vector<ReasonCount>(limits::reason_counts_max, ReasonCount(text, text, 1))),
        WorkersReply(std::vector<WorkerStatus>(limits::sessions_max, worker)),
    };
    for (const auto& message : largest) {
        const auto back = there_and_back(message);
        EXPECT_TRUE(back.has_value()) << name_of(message) << ": " << name_of(back.error());
    }
}

template <class M>
bool refused(const M& message) {
    const auto back = there_and_back(message);
    return back.has_error() && back.error() == WireError::bad_value;
}

TEST(Messages, WhatCannotBeTrueIsRefused) {
    const PartId part(1, 1, 0);
    EXPECT_TRUE(refused(Pull(limits::leases_per_worker_max + 1)));
    EXPECT_TRUE(refused(Pull(1, 0, limits::threads_behind_relay_max + 1, 1)));
    EXPECT_TRUE(refused(Pull(1, 0, 1, 0)));
    EXPECT_TRUE(refused(Lease(1, 1, 1, {0, 5, 0}, 0))) << "an empty range";
    EXPECT_TRUE(refused(Lease(1, 1, 1, {0, std::numeric_limits<std::uint64_t>::max(), 2}, 0))) << "overflow";
    EXPECT_TRUE(refused(Lease(1, 1, 1, {limits::lights_max + limits::subspaces_max, 0, 1}, 0)));
    Lease too_few = test::sample_lease_of_flights();
    too_few.flights.pop_back();
    EXPECT_TRUE(refused(too_few)) << "one of its particles is missing";
    EXPECT_TRUE(refused(PartsHeld(1, {3, 3}, 0, false)));
    EXPECT_TRUE(refused(PartsHeld(1, {limits::subspaces_max}, 0, false)));
    EXPECT_TRUE(refused(ResultFlights(part, 0, {})));
    EXPECT_TRUE(refused(ResultWork(part, {})));
    EXPECT_TRUE(refused(ResultWork(part, {{3, 1, 1}, {3, 1, 1}})));
    EXPECT_TRUE(refused(ResultWork(part, {{limits::subspaces_max, 1, 1}})));
    EXPECT_TRUE(refused(ResultWork(part, {{3, static_cast<std::uint32_t>(limits::hits_per_map_max) + 1, 1}})));
    EXPECT_TRUE(refused(ResultWork(part, {{3, 1, ~std::uint64_t{0}}}))) << "more seconds than a result takes";
    EXPECT_TRUE(refused(ReturnLeases(ReturnReason::ending, {})));
    EXPECT_TRUE(refused(ResultHits(part, 0, {}, {})));
    EXPECT_TRUE(refused(ResultHits(part, 0, {{}, {}}, {1})));
    EXPECT_TRUE(refused(ResultHits(part, 0, {{}}, {limits::energy_ticks_max + 1})));
    EXPECT_TRUE(refused(ResultHits(PartId(1, 1, limits::parts_per_result_max), 0, {{}}, {})));
    EXPECT_TRUE(refused(ResultMap(part, {}, {})));
    EXPECT_TRUE(refused(SubmitReply(0, {})));
    EXPECT_TRUE(refused(SubmitReply(3, {1})));
    EXPECT_TRUE(refused(Manifest(FileManifest(Digest(), limits::chunk_bytes + 1, {Digest()}))));
    EXPECT_TRUE(refused(Submit(1, JobSpec(), FileManifest(Digest(), limits::scene_bytes_max + 1, {}))));
    const std::vector<std::function<void(Flight&)>> impossible = {
        [](Flight& flight) {
            flight.direction = {0.6, 0, 0.6};
        },
        [](Flight& flight) { flight.direction.y = std::numeric_limits<double>::quiet_NaN(); },
        [](Flight& flight) { flight.origin.x = 1e12; },
        [](Flight& flight) { flight.travelled_m = -1; },
        [](Flight& flight) { flight.travelled_m = std::numeric_limits<double>::infinity(); },
        [](Flight& flight) { flight.bounce = limits::bounces_max; },
        [](Flight& flight) { flight.wavelength = wavelength_bins; },
        [](Flight& flight) { flight.energy = 0; },
        [](Flight& flight) { flight.start_energy = limits::energy_ticks_max + 1; },
    };
    for (const auto& spoil : impossible) {
        Flight flight = unpack_flight(test::sample_flight());
        spoil(flight);
        EXPECT_TRUE(refused(ResultFlights(part, 0, {pack_flight(flight, 1)})));
    }
    auto spec = test::sample_spec();
    spec.packing = Packing::automatic;
    EXPECT_TRUE(refused(JobInfo(1, Digest(), 1, spec, 1, 1)));
}

TEST(Messages, SecondsThatCannotBeAreRefused) {
    const auto done = [](double wall_s, double cpu_s) {
        return ResultDone(1, 1, {Claim(1, 1, {0, 0, 150})}, 0, test::sample_balance(150), wall_s, cpu_s);
    };
    EXPECT_FALSE(refused(done(limits::result_seconds_max, limits::result_seconds_max)));
    EXPECT_TRUE(refused(done(1.01 * limits::result_seconds_max, 0)));
    EXPECT_TRUE(refused(done(0, std::numeric_limits<double>::max()))) << "two of them would be infinite";
    EXPECT_TRUE(refused(done(0, -1)));
}

TEST(Messages, CreditThatCannotBeIsRefused) {
    const auto welcome = [](std::uint32_t credit) {
        Welcome says(1);
        says.results_in_flight = credit;
        return says;
    };
    EXPECT_FALSE(refused(welcome(limits::results_in_flight_max)));
    EXPECT_TRUE(refused(welcome(limits::results_in_flight_max + 1)));
    EXPECT_TRUE(refused(welcome(0)));
}

TEST(Messages, BalanceThatCannotBeIsRefused) {
    const auto done = [](const EnergyBalance& balance) {
        return ResultDone(1, 1, {Claim(1, 1, {0, 0, 150})}, 0, balance, 0, 0);
    };
    auto balance = test::sample_balance(150);
    EXPECT_FALSE(refused(done(balance)));
    balance = test::sample_balance(149);
    EXPECT_FALSE(refused(done(balance))) << "one may have been in flight: the master knows";
    balance = test::sample_balance(151);
    EXPECT_TRUE(refused(done(balance))) << "more particles than the ranges have";
    balance = test::sample_balance(150);
    ++balance.emitted_by_batch[0];
    EXPECT_TRUE(refused(done(balance)));
    balance = test::sample_balance(150);
    balance.absorbed = balance.escaped = balance.cut_off = std::numeric_limits<std::int64_t>::max();
    EXPECT_TRUE(refused(done(balance))) << "would overflow";
}

}  // namespace
}  // namespace lumenfarm::wire
