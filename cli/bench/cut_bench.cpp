#include "cli/bench/cut_bench.h"

#include "common/service/thread_time.h"
#include "common/solution/cut_learning.h"
#include "common/solution/hit_work.h"
#include "common/solution/solution.h"
#include "common/transport/scene_in_parts.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lumenfarm {
namespace {

constexpr std::uint64_t particles_max = 50'000'000;
constexpr std::uint64_t no_end = std::numeric_limits<std::uint64_t>::max();

std::vector<SubspaceCost> trace(const SceneInParts& parts, const Emission& emission, const JobSpec& spec,
                                LightMap& map) {
    const Emitter emitter(parts.palette, emission, parts.subspaces.partition(), parts.extent);
    WorkMeter meter(thread_cpu_seconds);
    const std::vector<std::uint64_t> of_lights = apportion(emission, spec.particles);
    for (std::uint32_t light = 0; light < of_lights.size(); ++light)
        for (std::uint64_t first = 0; first < of_lights[light]; first += limits::slice_particles_in_parts) {
            const std::uint64_t count = std::min(limits::slice_particles_in_parts, of_lights[light] - first);
            TracedFlights traced;
            parts.territories[0].emit(spec, {light, first, count}, emitter, no_end, traced, &meter);
            map.add(emission, light, traced.hits.records, traced.hits.energies);
        }
    std::vector<SubspaceCost> costs(parts.subspaces.all().size());
    for (const SubspaceWork& each : meter.take()) costs[each.subspace] = {each.hits, each.nanoseconds};
    return costs;
}

double imbalance_of(const std::vector<SubspaceCost>& costs, std::uint64_t SubspaceCost::*what) {
    std::vector<double> shares;
    for (const SubspaceCost& cost : costs) shares.push_back(static_cast<double>(cost.*what));
    return imbalance(shares);
}

class CutRounds {
public:
    CutRounds(const Scene& scene, Emission emission, TexelLayout layout, std::uint64_t particles)
        : scene_(scene), emission_(std::move(emission)), layout_(std::move(layout)), map_(layout_) {
        spec_.particles = particles;
    }

    CutRounds(const CutRounds&) = delete;

    /// Under this cut, with other particles than before.
    Result<std::vector<SubspaceCost>> measure(std::string name, const Subspaces& cut) {
        const auto parts = SceneInParts::make(scene_, cut);
        if (!parts) return parts.error();
        ++spec_.seed;
        std::vector<SubspaceCost> costs = trace(**parts, emission_, spec_, map_);
        figures_.push_back({std::move(name), imbalance_of(costs, &SubspaceCost::hits),
                            imbalance_of(costs, &SubspaceCost::nanoseconds)});
        return costs;
    }
    std::vector<SpreadWork> hits() { return hit_work(scene_, layout_, map_.texels()); }
    std::vector<CutFigures> figures() && { return std::move(figures_); }

private:
    const Scene& scene_;
    Emission emission_;
    TexelLayout layout_;
    LightMap map_;  ///< of all that was traced
    JobSpec spec_;
    std::vector<CutFigures> figures_;
};

}  // namespace

Result<std::vector<CutFigures>> bench_cuts(const Scene& scene, std::uint32_t subspaces, std::uint32_t learned_cuts,
                                           std::uint64_t particles) {
    if (particles == 0 || particles > particles_max)
        return bad_input("particles is " + std::to_string(particles) + "; it must be from 1 to " +
                         std::to_string(particles_max));
    auto emission = make_emission(scene);
    if (!emission) return emission.error();
    JobSpec spec;
    spec.particles = particles;
    auto layout = TexelLayout::make(scene, spec);
    if (!layout) return layout.error();
    std::vector<double> shares;
    for (const LightEmission& light : emission->lights) shares.push_back(light.share);
    const WeightedOctree octree = make_weighted_octree(scene, {}, shares);
    auto planned = Subspaces::cut(octree, subspaces);
    if (!planned) return planned.error();

    CutRounds rounds(scene, std::move(*emission), std::move(*layout), particles);
    const Box root = planned->root();
    if (const auto costs = rounds.measure("unweighted", Subspaces::cut(root, {{root, 1}}, subspaces)); !costs)
        return costs.error();
    Subspaces cut = std::move(*planned);
    WorkTimes known;
    auto costs = rounds.measure("planned", cut);
    for (std::uint32_t learned_from = 0; costs && learned_from < learned_cuts; ++learned_from) {
        if (learned_from > 0) known.costs = std::move(*costs);
        LearnedCut learned = learn_cut(cut, planned_work(octree), rounds.hits(), known, 1);
        if (learned.lesson) known.lessons.push_back(std::move(*learned.lesson));
        cut = Subspaces::of(root, std::move(learned.cut));
        costs = rounds.measure(learned_from == 0 ? "by hits" : "by time " + std::to_string(learned_from), cut);
    }
    if (!costs) return costs.error();
    return std::move(rounds).figures();
}

}  // namespace lumenfarm
