#include "cli/bench/cut_bench.h"
#include "cli/import/import.h"
#include "cli/products/inspect_cuts.h"
#include "tests/solution/traced_run.h"
#include "tests/transport/weigh.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

/// How evenly subspaces share the work out, before and after it was measured.
namespace lumenfarm {
namespace {

Scene own_scene(const std::string& file) {
    return import_scene(std::filesystem::path(LUMENFARM_SOURCE_DIR) / "scenes" / file, {}).value().scene;
}

/// What a cut learns from some particles is worth for others, beside cuts that have learned nothing.
void expect_learned(const Scene& scene) {
    const std::uint64_t most = Subspaces::most(testing::weigh(scene));
    for (const std::uint32_t subspaces : {8u, 16u, 64u}) {
        if (subspaces > most) continue;
        const auto cuts = bench_cuts(scene, subspaces, 1, 100'000);
        ASSERT_TRUE(cuts) << cuts.error().sentence;
        ASSERT_EQ(cuts->size(), 3u);
        const CutFigures& unweighted = cuts->front();
        const CutFigures& learned = cuts->back();
        EXPECT_EQ(learned.cut, "by hits");
        EXPECT_LE(learned.of_hits, 1.25) << subspaces;
        EXPECT_LT(learned.of_hits, unweighted.of_hits) << subspaces;
    }
}

TEST(LearnedCut, SharesTheWorkOfThePaperRoomOutEvenly) { expect_learned(own_scene("paper_room.gltf")); }

TEST(LearnedCut, SharesTheWorkOutEvenlyWhereAllDetailIsInOneCorner) { expect_learned(own_scene("crumbs.gltf")); }

TEST(LearnedCut, OfNoParticlesOrNoSubspacesIsRefused) {
    for (const auto& [subspaces, particles] : {std::pair{0u, 10u}, {100'000u, 10u}, {8u, 0u}}) {
        const auto cuts = bench_cuts(own_scene("paper_room.gltf"), subspaces, 1, particles);
        ASSERT_FALSE(cuts);
        EXPECT_EQ(cuts.error().code, ErrorCode::bad_input);
    }
}

TEST(LearnedCut, IsShownByInspect) {
    JobSpec spec;
    spec.particles = 50'000;
    const LoadedRun run = test::traced_run(own_scene("paper_room.gltf"), spec);
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
