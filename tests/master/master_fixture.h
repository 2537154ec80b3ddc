#pragma once

#include "common/scene/scene_file.h"
#include "master/master_core.h"
#include "tests/simulation/fake_tracer.h"
#include "tests/simulation/small_scene.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lumenfarm::testing {

inline constexpr SessionId ann = 1, bob = 2;
inline constexpr std::uint64_t fingerprint = 7;

/// A master with one job of small_scene(), and what it wants done.
class MasterTest : public ::testing::Test {
protected:
    MasterTest() : master_(policy()) {}

    static MasterPolicy policy() {
        MasterPolicy policy;
        policy.fingerprint = fingerprint;
        return policy;
    }

    JobId submit(JobSpec spec, std::uint64_t key) {
        const wire::FileManifest manifest(scene_digest(bytes_), bytes_.size(), chunk_digests(bytes_));
        take(master_.on_message(embedding_session, wire::Submit(key, spec, manifest), 1, now_s_));
        const auto admit = find<Admit>();
        if (!admit) return 0;
        take(master_.on_admitted(*admit, std::vector<std::uint32_t>{}, now_s_));
        const auto reply = sent<wire::SubmitReply>(embedding_session);
        prepare({});
        return reply ? reply->job : 0;
    }
    /// Carries out a Prepare, if there is one.
    void prepare(RecoveredJob recovered) {
        const auto prepare = std::exchange(prepare_, std::nullopt);
        if (!prepare) return;
        prepared_ = prepare_job(prepare->job.spec, bytes_).value();
        recovered.prepared = prepared_;
        recovered.committed.resize(prepared_->particles.size());
        take(master_.on_prepared(prepare->job.id(), std::move(recovered), now_s_), true);
    }
    void store_solution() {
        ASSERT_TRUE(solution_);
        JobRecord record = solution_->record;
        record.status.state = record.complete ? wire::JobState::done : wire::JobState::cancelled;
        record.has_solution = true;
        take(master_.on_solution_stored(*solution_, record, now_s_));
    }

    static JobSpec records_job() {
        JobSpec spec;
        spec.particles = 10'000;
        spec.particles_per_set = 1'000;
        spec.packing = Packing::records;
        return spec;
    }

    void greet(SessionId session, std::uint64_t instance, std::uint64_t print = fingerprint) {
        leases_[session] = 0;
        take(master_.on_connect(session, "10.0.0.1:1", now_s_));
        wire::Hello hello(wire::Role::worker, "w" + std::to_string(instance), instance);
        hello.threads = 2;
        hello.fingerprint = print;
        take(master_.on_message(session, hello, 0, now_s_));
    }
    void join(SessionId session, std::uint64_t instance, std::vector<wire::LeaseProgress> held = {}) {
        greet(session, instance);
        take(master_.on_message(session, wire::Progress(0, std::move(held)), 0, now_s_));
    }
    std::vector<wire::Lease> pull(SessionId session, std::uint32_t sets) {
        take(master_.on_message(session, wire::Pull(sets, leases_[session]), 0, now_s_));
        return all_sent<wire::Lease>(session);
    }

    /// Traces a lease (or the part of it) honestly.
    std::pair<wire::ResultHits, wire::ResultDone> trace(const wire::Lease& lease, std::uint64_t number,
                                                        std::optional<ParticleRange> part = {}) {
        const ParticleRange range = part.value_or(lease.range);
        TracedHits hits;
        FakeTracer(prepared_->scene).trace(records_job(), range, hits, nullptr);
        wire::ResultHits records(wire::PartId(lease.job, number, 0), range.source, hits.records, {});
        wire::ResultDone done(lease.job, number, {wire::Claim(lease.lease, lease.epoch, range)}, 1, hits.balance, 0.1,
                              0);
        return {records, done};
    }
    wire::Verdict deliver(SessionId session, const std::pair<wire::ResultHits, wire::ResultDone>& result) {
        take(master_.on_message(session, result.first, 0, now_s_));
        take(master_.on_message(session, result.second, 0, now_s_));
        const auto ack = sent<wire::ResultAck>(session);
        EXPECT_TRUE(ack.has_value());
        return ack ? ack->verdict : wire::Verdict::invalid;
    }

    /// Keeps the effects, and carries out those of the disk unless it is held.
    void take(Effects effects, bool add = false) {
        if (!add) effects_.clear();
        std::vector<std::uint64_t> tickets;
        std::vector<StoreRecord> records;
        for (Effect& effect : effects) {
            if (const auto* send = std::get_if<Send>(&effect))
                leases_[send->session] += std::holds_alternative<wire::Lease>(send->message);
            if (const auto* result = std::get_if<StoreResult>(&effect)) tickets.push_back(result->ticket);
            if (const auto* record = std::get_if<StoreRecord>(&effect)) records.push_back(*record);
            if (const auto* prepare = std::get_if<Prepare>(&effect)) prepare_ = *prepare;
            if (const auto* solution = std::get_if<StoreSolution>(&effect)) solution_ = *solution;
            effects_.push_back(std::move(effect));
        }
        if (disk_held_) return held_.insert(held_.end(), tickets.begin(), tickets.end()), void();
        if (!tickets.empty()) take(master_.on_results_stored(tickets, thresholds(), now_s_), true);
        for (const StoreRecord& record : records) take(master_.on_record_stored(record, {}, now_s_), true);
    }
    static std::map<JobId, Merged> thresholds() { return {{1, {100, {}}}}; }
    template <class E>
    std::optional<E> find() const {
        for (const Effect& effect : effects_)
            if (const auto* found = std::get_if<E>(&effect)) return *found;
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
    template <class M>
    std::optional<M> sent(SessionId session) const {
        const auto all = all_sent<M>(session);
        return all.empty() ? std::nullopt : std::optional<M>(all.front());
    }

    std::vector<std::byte> bytes_ = encode_scene(small_scene());
    std::shared_ptr<const PreparedJob> prepared_;
    MasterCore master_;
    Effects effects_;
    std::map<SessionId, std::uint64_t> leases_;  ///< sent in the session
    std::optional<Prepare> prepare_;             ///< the last one
    std::optional<StoreSolution> solution_;      ///< the last one
    bool disk_held_ = false;
    std::vector<std::uint64_t> held_;  ///< tickets
    double now_s_ = 0;
};

}  // namespace lumenfarm::testing
