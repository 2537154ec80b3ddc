#pragma once

#include "common/scene/scene_file.h"
#include "relay/prepare_lent.h"
#include "relay/relay_core.h"
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

using ::lumenfarm::testing::FakeTracer;
using ::lumenfarm::testing::small_scene;

inline constexpr SessionId ann = 1, bob = 2;
inline constexpr std::uint64_t fingerprint = 7, own_instance = 99;

inline MasterPolicy farm_policy() {
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

}  // namespace lumenfarm::relay
