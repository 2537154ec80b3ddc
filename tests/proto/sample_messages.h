#pragma once

#include "proto/messages.h"

#include <vector>

namespace lumenfarm::test {

inline Digest sample_digest(std::uint8_t start) {
    Digest digest;
    for (std::size_t i = 0; i < digest.bytes.size(); ++i) digest.bytes[i] = static_cast<std::uint8_t>(start + i);
    return digest;
}

inline EnergyBalance sample_balance(std::uint64_t particles) {
    EnergyBalance balance;
    balance.emitted = 6'400;
    balance.emitted_by_batch[3] = 6'400;
    balance.absorbed = 6'000;
    balance.escaped = 500;
    balance.cut_off = -100;
    balance.particles = particles;
    balance.hits = 250;
    return balance;
}

inline JobSpec sample_spec() {
    JobSpec spec;
    spec.particles = 205'000;
    spec.seed = 7;
    spec.packing = Packing::maps;
    spec.texel_m = 0.05;
    spec.keep_hits = 1'000;
    spec.name = "paper room";
    spec.priority = -3;
    return spec;
}

inline wire::JobStatus sample_job_status() {
    wire::JobStatus status;
    status.job = 12;
    status.name = "cornell";
    status.state = wire::JobState::running;
    status.scene = sample_digest(9);
    status.packing = Packing::records;
    status.particles = 20'000'000;
    status.committed = 5'000'000;
    status.particles_per_second = 2.5e6;
    status.eta_seconds = 6.25;
    status.digest = sample_digest(77);
    status.sentence = "nothing failed";
    return status;
}

inline wire::WorkerStatus sample_worker_status() {
    wire::WorkerStatus status;
    status.session = 5;
    status.name = "office-3";
    status.address = "192.168.1.17:50123";
    status.state = wire::WorkerState::working;
    status.role = wire::Role::relay;
    status.threads = 8;
    status.memory_bytes = std::uint64_t{16} << 30;
    status.isa = "avx2";
    status.particles = 123'456;
    return status;
}

inline wire::FlightRecord sample_flight() {
    Flight flight;
    flight.origin = {1, -2, 0.5};
    flight.direction = {0.6, 0, -0.8};
    flight.travelled_m = 3.25;
    flight.from_triangle = 17;
    flight.particle = 5'000;
    flight.bounce = 3;
    flight.wavelength = 120;
    flight.energy = 60'000;
    flight.start_energy = 65'000;
    return wire::pack_flight(flight, 1);
}

inline wire::Lease sample_lease_of_flights() {
    wire::Lease lease(5, 2, 12, {4, 100, 3}, 1u << 30);
    lease.flights.assign(3, sample_flight());
    return lease;
}

/// At least one of every type, with no field left at its default where that would hide a mistake.
inline wire::Traffic sample_traffic() {
    wire::Traffic traffic;
    traffic.bytes_in = 1'000'000;
    traffic.bytes_out = 2'000;
    traffic.messages_in = 30;
    traffic.messages_out = 4;
    return traffic;
}

inline std::vector<wire::Message> sample_messages() {
    using namespace wire;
    Hello hello(Role::worker, "office-3", 0x1234567890abcdefu);
    hello.threads = 8;
    hello.memory_bytes = std::uint64_t{16} << 30;
    hello.isa = "avx2";
    hello.fingerprint = 42;
    const PartId part(12, 3, 1);
    const std::vector<HitRecord> records = {{7, 100, 200, 300, 400, 1'500, hit_flags(2, 5, 1)}, {8, 0, 0, 1, 2, 3, 4}};
    const FileManifest manifest(sample_digest(1), limits::chunk_bytes + 5, {sample_digest(2), sample_digest(3)});
    const Claim claim(4, 2, {1, 5'000, 100});
    return {
        hello,
        Welcome(99),
        Goodbye(GoodbyeReason::shutting_down, "the master restarts"),
        Heartbeat(17),
        HeartbeatReply(17),
        Refusal(RefusalReason::no_such_file, "there is no such file", sha256(std::as_bytes(std::span("abc")))),
        Pull(4, 1'000'000, 40, 20),
        JobInfo(12, sample_digest(9), 100'000, sample_spec(), 0.05, 2.0),
        Lease(4, 2, 12, {1, 5'000, 100}, 1u << 30),
        sample_lease_of_flights(),
        PartsHeld(12, {0, 3, 7}, 1'000'000, true),
        JobGone(12),
        ReturnLeases(ReturnReason::no_scene, {{4, 2}, {5, 1}}),
        Progress(1.5e6, {{1, 4, 50}, {2, 5, 0}}),
        Drain(12),
        ResultHits(part, 1, records, {}),
        ResultHits(part, 1, records, {70'000, 12}),
        ResultMap(part, {{3, 2, 100, 90, 80, 70, 60}, {9, 1, 50, 40, 30, 20, 10}}, {{0, 33, 100, 80, 2}}),
        ResultKept(part, {{records[0], 1, 65'000}}),
        ResultFlights(part, 7, {sample_flight(), sample_flight()}),
        ResultWork(part, {{0, 5, 1'000}, {7, 0, 300}}),
        ResultDone(12, 3, {claim, {5, 1, {0, 0, 50}}}, 2, sample_balance(150), 1.25, 1.5),
        ResultAck(12, 3, Verdict::stale, "lease 4 was given out again"),
        ManifestRequest(sample_digest(1)),
        Manifest(manifest),
        ChunkRequest(sample_digest(1), 1),
        Chunk(sample_digest(1), 1, std::vector<std::byte>(300, std::byte{7})),
        Submit(0xfeed, sample_spec(), manifest),
        SubmitReply(12, {}),
        SubmitReply(0, {0, 1}),
        StatusRequest(std::nullopt),
        StatusRequest(12),
        StatusReply({sample_job_status(), JobStatus()}, {{"sent_off", "farm_full", 3}, ReasonCount()},
                    sample_traffic()),
        WorkersRequest(),
        WorkersReply({sample_worker_status(), WorkerStatus()}),
        ControlRequest(12, JobAction::extend, 5'000),
        ControlReply(12, JobState::done),
        FetchRequest(12),
        FetchReply(12, sample_digest(9), sample_digest(10), true),
    };
}

}  // namespace lumenfarm::test
