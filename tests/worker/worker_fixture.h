#pragma once

#include "worker/worker_core.h"

#include "common/scene/scene_file.h"
#include "tests/simulation/fake_tracer.h"
#include "tests/simulation/small_scene.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace lumenfarm::worker {

/// A worker with two slots, and what it wants done. The test is master, tracer and clock.
class WorkerTest : public ::testing::Test {
protected:
    WorkerTest() : core_(identity()) {}

    static WorkerIdentity identity() {
        WorkerIdentity identity;
        identity.threads = 2;
        identity.instance = 5;
        return identity;
    }
    wire::JobInfo info(Packing packing = Packing::records) const {
        JobSpec spec;
        spec.packing = packing;
        return {1, scene_digest(bytes_), bytes_.size(), spec, 0.1, 2};
    }
    static wire::Lease lease(std::uint64_t number, std::uint64_t particles = 1'000, JobId job = 1) {
        return {number, 1, job, {0, number * 1'000'000, particles}, ~std::uint64_t{0}};
    }

    void welcome() {
        take(core_.on_connect(now_s_));
        hear(wire::Welcome(1));
    }
    void hear(wire::Message message) { take(core_.on_message(std::move(message), now_s_)); }
    /// The job with its scene from the cache, ready to trace.
    void ready(Packing packing = Packing::records) {
        hear(info(packing));
        take(core_.on_scene_loaded(scene_digest(bytes_), std::make_shared<const std::vector<std::byte>>(bytes_),
                                   now_s_));
        prepare();
    }
    void prepare() {
        const auto effect = find<PrepareJob>();
        ASSERT_TRUE(effect);
        take(core_.on_job_prepared(effect->info, context(effect->info), now_s_));
    }
    std::shared_ptr<const JobContext> context(const wire::JobInfo& of) const {
        auto scene = std::make_shared<SceneContext>();
        scene->scene = decode_scene(bytes_).value();
        scene->tracer = std::make_unique<testing::FakeTracer>(scene->scene);
        return make_job_context(of, scene, nullptr).value();
    }
    /// What a slot reports after a set of packing records.
    void finish_set(std::size_t slot, const wire::Lease& lease) {
        SlotReport report;
        report.set_finished = true;
        report.result = parcel(lease, lease.range.count);
        take(core_.on_slot(slot, std::move(report), now_s_));
    }
    static Parcel parcel(const wire::Lease& lease, std::uint64_t particles) {
        Parcel parcel;
        parcel.job = lease.job;
        ParticleRange range = lease.range;
        range.count = particles;
        parcel.claims.emplace_back(lease.lease, lease.epoch, range);
        parcel.balance.particles = particles;
        return parcel;
    }
    /// Sends what may be sent now and gives the results that were finished.
    std::vector<wire::ResultDone> pump() {
        std::vector<wire::ResultDone> done;
        while (const auto part = core_.next_bulk())
            if (const auto* last = std::get_if<wire::ResultDone>(&*part)) done.push_back(*last);
        return done;
    }

    std::uint64_t discarded(Discard reason) const { return core_.counts().discards.of(reason); }

    void take(Effects effects) { effects_ = std::move(effects); }
    template <class E>
    std::vector<E> all() const {
        std::vector<E> found;
        for (const Effect& effect : effects_)
            if (const auto* one = std::get_if<E>(&effect)) found.push_back(*one);
        return found;
    }
    template <class E>
    std::optional<E> find() const {
        const auto found = all<E>();
        return found.empty() ? std::nullopt : std::optional<E>(found.front());
    }
    template <class M>
    std::vector<M> all_sent() const {
        std::vector<M> found;
        for (const Send& send : all<Send>())
            if (const auto* message = std::get_if<M>(&send.message)) found.push_back(*message);
        return found;
    }
    template <class M>
    std::optional<M> sent() const {
        const auto found = all_sent<M>();
        return found.empty() ? std::nullopt : std::optional<M>(found.front());
    }

    std::vector<std::byte> bytes_ = encode_scene(testing::small_scene());
    WorkerCore core_;
    Effects effects_;
    double now_s_ = 0;
};

}  // namespace lumenfarm::worker
