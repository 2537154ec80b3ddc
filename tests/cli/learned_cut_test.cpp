#include "cli/import/import.h"
#include "cli/products/inspect_cuts.h"
#include "common/solution/hit_work.h"
#include "tests/solution/traced_run.h"
#include "tests/transport/scene_in_parts.h"

#include <time.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

/// How evenly subspaces share the work out, before and after it was measured.
namespace lumenfarm {
namespace {

LoadedRun traced(const Scene& scene, std::uint64_t particles, std::uint64_t seed) {
    JobSpec spec;
    spec.particles = particles;
    spec.seed = seed;
    return test::traced_run(scene, spec);
}

double processor_s() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Particles of a scene in parts: where they left hits, and what each subspace took.
struct Measured {
    LightMap map;
    std::vector<SubspaceCost> costs;

    double imbalance_of(std::uint64_t SubspaceCost::*what) const {
        std::vector<double> shares;
        for (const SubspaceCost& cost : costs) shares.push_back(static_cast<double>(cost.*what));
        return imbalance(shares);
    }
};

Measured measure(const LoadedRun& run, const Subspaces& cut, std::uint64_t particles, std::uint64_t seed) {
    const testing::SceneInParts parts(run.scene, cut);
    const Emission emission = make_emission(parts.palette.scene).value();
    const Emitter emitter(parts.palette, emission, cut.partition(), parts.extent);
    JobSpec spec;
    spec.seed = seed;
    WorkMeter meter(processor_s);
    Measured measured{LightMap(run.layout), std::vector<SubspaceCost>(cut.all().size())};
    const auto of_lights = apportion(emission, particles);
    for (std::uint32_t light = 0; light < of_lights.size(); ++light)
        for (std::uint64_t first = 0; first < of_lights[light]; first += limits::slice_particles_in_parts) {
            TracedFlights traced;
            const std::uint64_t count = std::min(limits::slice_particles_in_parts, of_lights[light] - first);
            parts.territories[0].emit(spec, {light, first, count}, emitter, limits::hits_per_slice_max, traced, &meter);
            measured.map.add(emission, light, traced.hits.records, traced.hits.energies);
        }
    for (const SubspaceWork& each : meter.take()) measured.costs[each.subspace] = {each.hits, each.nanoseconds};
    return measured;
}

/// What a cut learns from some particles is worth for others, beside cuts that have learned nothing.
void expect_learned(const std::string& name, const Scene& scene) {
    const LoadedRun run = traced(scene, 1'000, 1);
    const WeightedOctree octree = testing::weigh(run.scene);
    const Box root = octree.octree().box(Octree::root());
    for (const std::uint32_t count : {8u, 16u, 64u}) {
        if (count > Subspaces::most(octree)) continue;
        const Subspaces unweighted = Subspaces::cut(root, {{root, 1}}, count);
        const Subspaces weighted = Subspaces::cut(root, planned_work(octree), count);
        const auto learn = [&](const Subspaces& cut, bool from_time) {
            const Measured seen = measure(run, cut, 100'000, 1);
            auto work = hit_work(run.scene, run.layout, seen.map.texels());
            if (from_time) work = costed_work(std::move(work), cut, seen.costs);
            return Subspaces::cut(root, corrected_work(planned_work(octree), work), count);
        };
        const Subspaces by_hits = learn(weighted, false), by_time = learn(by_hits, true), again = learn(by_time, true);
        std::cout << name << ", " << count << " subspaces, largest share over the mean, of hits and of processor time:";
        const auto show = [&](const char* which, const Subspaces& cut) {
            const Measured others = measure(run, cut, 200'000, 2);
            const double of_hits = others.imbalance_of(&SubspaceCost::hits);
            std::cout << "  " << which << " " << of_hits << " " << others.imbalance_of(&SubspaceCost::nanoseconds);
            return of_hits;
        };
        const double before = show("unweighted", unweighted);
        show("planned", weighted);
        const double learned = show("learned from hits", by_hits);
        show("then from time", by_time);
        show("again", again);
        std::cout << "\n";
        EXPECT_LE(learned, 1.25) << name << ", " << count;
        EXPECT_LT(learned, before) << name << ", " << count;
    }
}

TEST(LearnedCut, SharesTheWorkOfThePaperRoomOutEvenly) {
    const auto imported = import_scene(std::filesystem::path(LUMENFARM_SOURCE_DIR) / "scenes" / "paper_room.gltf", {});
    ASSERT_TRUE(imported);
    expect_learned("paper room", imported->scene);
}

/// A large room with a lamp at one end and 3,000 small triangles in the far corner.
Scene detail_in_one_corner() {
    const auto imported = import_scene(std::filesystem::path(LUMENFARM_SOURCE_DIR) / "scenes" / "cornell.gltf", {});
    Scene scene = imported->scene;
    const Box box = bounding_box(scene);
    const Vec3d size = box.high - box.low;
    const auto first = static_cast<std::uint32_t>(scene.triangles.size());
    constexpr int side = 40;
    const auto at = [&](int i, int k) {
        const double height = 0.01 * (1 + (i * 7 + k * 13) % 5);
        return Vec3d{box.low.x + size.x * (0.02 + 0.12 * i / side), box.low.y + size.y * (0.02 + height),
                     box.low.z + size.z * (0.02 + 0.12 * k / side)};
    };
    for (int i = 0; i < side; ++i)
        for (int k = 0; k < side; ++k) {
            const auto corner = static_cast<std::uint32_t>(scene.positions.size());
            for (const auto& [a, b] : {std::pair{i, k}, {i + 1, k}, {i, k + 1}, {i + 1, k + 1}})
                scene.positions.push_back(at(a, b).as<float>());
            scene.triangles.push_back({corner, corner + 2, corner + 1});
            scene.triangles.push_back({corner + 1, corner + 2, corner + 3});
        }
    scene.surfaces.push_back(
        {"crumbs", "crumbs", first, static_cast<std::uint32_t>(scene.triangles.size()) - first, 0});
    return scene;
}

TEST(LearnedCut, SharesTheWorkOutEvenlyWhereAllDetailIsInOneCorner) {
    expect_learned("detail in one corner", detail_in_one_corner());
}

TEST(LearnedCut, IsShownByInspect) {
    const auto imported = import_scene(std::filesystem::path(LUMENFARM_SOURCE_DIR) / "scenes" / "paper_room.gltf", {});
    ASSERT_TRUE(imported);
    const LoadedRun run = traced(imported->scene, 50'000, 1);
    const auto cuts = balance_of_cuts(run, testing::weigh(run.scene), 16);
    ASSERT_EQ(cuts.size(), 3u);
    for (const CutBalance& cut : cuts) {
        EXPECT_EQ(cut.planned.size(), 16u);
        EXPECT_EQ(cut.measured.size(), 16u);
        EXPECT_NE(cuts_table(cuts).find(cut.name), std::string::npos);
    }
    EXPECT_GT(imbalance(cuts[0].measured), imbalance(cuts[2].measured));
    EXPECT_EQ(cuts_document(cuts).size(), 3u);
}

}  // namespace
}  // namespace lumenfarm
