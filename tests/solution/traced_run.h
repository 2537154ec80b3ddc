#pragma once

#include "common/scene/scene_file.h"
#include "common/solution/run_folder.h"
#include "common/support/ensure.h"
#include "common/transport/tracer.h"

#include <utility>

namespace lumenfarm::test {

/// Traces a job in one go: what a farm of any shape must arrive at.
inline LoadedRun traced_run(const Scene& scene, const JobSpec& spec) {
    const auto valid = validate(scene);
    ensure(valid.has_value(), valid ? "" : valid.error().sentence.c_str());
    auto tracer = TracerScene::make(scene);
    ensure(tracer.has_value(), "the scene can be traced");
    LoadedRun run{scene, scene_digest(encode_scene(scene)), (*tracer)->emission(), *TexelLayout::make(scene, spec), {}};
    LightMap map(run.layout);
    KeptHits kept(spec.keep_hits);
    Solution& solution = run.solution;
    solution.scene = run.scene_name;
    solution.spec = spec;
    const auto particles = apportion(run.emission, spec.particles);
    solution.committed.resize(particles.size());
    for (std::uint32_t light = 0; light < particles.size(); ++light) {
        constexpr std::uint64_t step = 50'000;
        for (std::uint64_t first = 0; first < particles[light]; first += step) {
            TracedHits hits;
            (*tracer)->trace(spec, {light, first, std::min(step, particles[light] - first)}, hits);
            map.add(run.emission, light, hits.records, hits.energies);
            for (std::size_t i = 0; i < hits.records.size(); ++i)
                kept.offer({hits.records[i], light,
                            hits.energies.empty() ? run.emission.lights[light].energy[hits.records[i].wavelength]
                                                  : hits.energies[i]});
            solution.balance += hits.balance;
        }
        solution.committed[light].insert(0, particles[light]);
    }
    solution.texels = map.texels();
    solution.surfaces = map.surfaces();
    solution.kept = kept.sorted();
    return run;
}

}  // namespace lumenfarm::test
