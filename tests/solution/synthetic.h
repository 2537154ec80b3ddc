#pragma once

#include "common/scene/scene_file.h"
#include "common/solution/run_folder.h"
#include "tests/solution/quad_scene.h"

#include <random>
#include <vector>

/// Solutions whose light is known because the test made it.
namespace lumenfarm::test {

/// A horizontal sheet 2 x 2 m about the origin that looks up, under a lamp far away; albedo 0.5.
inline Scene sheet_scene() {
    QuadScene quads;
    quads.quad("sheet", {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, quads.lambert(0.5));
    quads.point_light({0, 100, 0}, 1'000, false);
    return quads.scene;
}

/// An empty solution of `particles` committed particles, all emitted and none arrived.
inline LoadedRun empty_run(const Scene& scene, const JobSpec& spec) {
    LoadedRun run{scene, scene_digest(encode_scene(scene)), *make_emission(scene), *TexelLayout::make(scene, spec), {}};
    Solution& solution = run.solution;
    solution.scene = run.scene_name;
    solution.spec = spec;
    solution.texels.resize(run.layout.texel_count());
    solution.surfaces.resize(scene.surfaces.size());
    const auto particles = apportion(run.emission, spec.particles);
    solution.committed.resize(particles.size());
    for (std::size_t i = 0; i < particles.size(); ++i) solution.committed[i].insert(0, particles[i]);
    EnergyBalance& balance = solution.balance;
    balance.particles = spec.particles;
    for (std::int64_t& ticks : balance.emitted_by_batch) {
        ticks = static_cast<std::int64_t>(spec.particles * limits::energy_ticks_nominal / limits::batches);
        balance.emitted += ticks;
    }
    balance.escaped = balance.emitted;
    return run;
}

inline HitRecord random_record(std::mt19937_64& random, const Scene& scene) {
    HitRecord record;
    record.triangle = static_cast<std::uint32_t>(random() % scene.triangles.size());
    std::uint32_t b1 = random() % 65'536, b2 = random() % 65'536;
    if (b1 + b2 > 65'535) {
        b1 = 65'535 - b1;
        b2 = 65'535 - b2;
    }
    record.b1 = static_cast<std::uint16_t>(b1);
    record.b2 = static_cast<std::uint16_t>(b2);
    record.direction_u = static_cast<std::uint16_t>(random());
    record.wavelength = static_cast<std::uint16_t>(random() % wavelength_bins);
    record.flags = hit_flags(0, static_cast<std::uint32_t>(random() % 32), 0);
    return record;
}

/// Puts the hits into a run as one light's, analog.
inline void fill(LoadedRun& run, const std::vector<HitRecord>& records) {
    LightMap map(run.layout);
    map.add(run.emission, 0, records, {});
    KeptHits kept(run.solution.spec.keep_hits);
    for (const HitRecord& record : records) kept.offer({record, 0, run.emission.lights[0].energy[record.wavelength]});
    run.solution.texels = map.texels();
    run.solution.surfaces = map.surfaces();
    run.solution.kept = kept.sorted();
    run.solution.balance.hits = records.size();
}

inline std::vector<HitRecord> uniform_records(std::uint64_t seed, const Scene& scene, std::size_t count) {
    std::mt19937_64 random(seed);
    std::vector<HitRecord> records;
    for (std::size_t i = 0; i < count; ++i) records.push_back(random_record(random, scene));
    return records;
}

}  // namespace lumenfarm::test
