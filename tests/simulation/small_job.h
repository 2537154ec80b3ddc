#pragma once

#include "common/scene/scene_file.h"
#include "master/storage.h"
#include "tests/simulation/fake_tracer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

/// A job of the small scene and its results, of 200 particles each, for tests of what a master stores.
namespace lumenfarm::testing {

struct SmallJob {
    static constexpr std::uint64_t particles_of_a_result = 200;
    static constexpr MachineId machine = 7;

    explicit SmallJob(Strategy strategy = Strategy::sets, double texel_m = 2) {
        record.key = 3;
        record.spec.particles = 10'000;
        record.spec.texel_m = texel_m;
        record.spec.keep_hits = 50;
        record.spec.packing = Packing::records;
        record.spec.strategy = strategy;
        record.scene_bytes = scene.size();
        record.status.job = 1;
        record.status.scene = scene_digest(scene);
        prepared = prepare_job(record.spec, scene).value();
    }

    /// On a storage that is new.
    void begin(Storage& storage) const {
        EXPECT_TRUE(storage.start().has_value());
        EXPECT_TRUE(storage.put_scene(scene).has_value());
        JobRecord running = record;
        running.status.state = wire::JobState::running;
        EXPECT_TRUE(storage.put(StoreRecord{running, {}}).has_value());
        EXPECT_TRUE(storage.prepare({record}).has_value());
    }

    /// Numbers from 0 on, each with particles of its own.
    StagedResult result(std::uint64_t number) const {
        const ParticleRange range{0, number * particles_of_a_result, particles_of_a_result};
        TracedHits hits;
        FakeTracer(prepared->scene).trace(record.spec, range, hits, nullptr);
        StagedResult staged(1, number);
        staged.add(record.spec, *prepared, wire::ResultHits(wire::PartId(1, number, 0), 0, hits.records, {}));
        EXPECT_TRUE(
            staged.complete(*prepared, {1, number, {wire::Claim(number + 1, 0, range)}, 1, hits.balance, 0.5, 0.5}));
        return staged;
    }
    StoreResult stored(std::uint64_t number) const {
        return {number, 1, machine, std::make_shared<const StagedResult>(result(number))};
    }

    /// Of the solution of these results.
    Digest sums_of(const std::vector<std::uint64_t>& results) const {
        JobSums sums(record.spec, prepared);
        for (const std::uint64_t number : results) sums.merge(result(number));
        return solution_digest(sums.take(record.status.scene));
    }

    const std::vector<std::byte> scene = encode_scene(small_scene());
    JobRecord record;
    std::shared_ptr<const PreparedJob> prepared;
};

}  // namespace lumenfarm::testing
