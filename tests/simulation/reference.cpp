#include "tests/simulation/reference.h"

#include "common/scene/scene_file.h"
#include "master/job.h"
#include "tests/simulation/fake_tracer.h"
#include "tests/simulation/small_scene.h"

namespace lumenfarm::testing {

Solution reference_solution(const JobSpec& spec, const std::vector<IntervalSet>& committed) {
    const auto bytes = encode_scene(small_scene());
    const auto prepared = prepare_job(spec, bytes).value();
    // with subspaces the farm traces in earnest
    const auto tracer = spec.strategy == Strategy::subspaces
                            ? std::move(TracerScene::make(prepared->scene).value())
                            : std::unique_ptr<TracerScene>(std::make_unique<FakeTracer>(prepared->scene));
    LightMap sums(prepared->layout);
    KeptHits kept(spec.keep_hits);
    Solution solution;
    solution.scene = scene_digest(bytes);
    solution.spec = spec;
    solution.committed = committed;
    for (std::uint32_t light = 0; light < committed.size(); ++light) {
        TracedHits hits;
        for (const auto& [begin, end] : committed[light].intervals())
            tracer->trace(spec, {light, begin, end - begin}, hits, nullptr);
        sums.add(tracer->emission(), light, hits.records, hits.energies);
        for (std::size_t i = 0; i < hits.records.size(); ++i) {
            const std::uint32_t energy = hits.energies.empty()
                                             ? tracer->emission().lights[light].energy[hits.records[i].wavelength]
                                             : hits.energies[i];
            kept.offer({hits.records[i], light, energy});
        }
        solution.balance += hits.balance;
    }
    solution.texels = sums.texels();
    solution.surfaces = sums.surfaces();
    solution.kept = kept.sorted();
    return solution;
}

}  // namespace lumenfarm::testing
