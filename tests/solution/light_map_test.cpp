#include "common/solution/solution.h"

#include "tests/solution/synthetic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace lumenfarm {
namespace {

JobSpec small_job() {
    JobSpec spec;
    spec.particles = 64'000;
    spec.texel_m = 0.25;
    spec.keep_hits = 100;
    return spec;
}

TEST(LightMap, AHitAddsItsEnergyToItsTexelAndBatch) {
    LoadedRun run = test::empty_run(test::sheet_scene(), small_job());
    HitRecord hit;
    hit.triangle = 1;
    hit.b1 = 20'000;
    hit.b2 = 30'000;
    hit.wavelength = 1'750;  // 555 nm
    hit.flags = hit_flags(3, 17, 1);
    const std::vector<std::uint32_t> energies{100'000};
    LightMap map(run.layout);
    map.add(run.emission, 0, std::vector{hit}, energies);

    const auto ratio = xyz_ratios()[1'750].xyz;
    const auto weighted = [&](std::uint32_t r) {
        return static_cast<std::int64_t>((100'000ull * r + (1 << 19)) >> 20);
    };
    const TexelSums& texel = map.texels()[run.layout.texel_of(hit)];
    EXPECT_EQ(texel.radiant, 100'000);
    EXPECT_EQ(texel.x, weighted(ratio[0]));
    EXPECT_EQ(texel.y, weighted(ratio[1]));
    EXPECT_NEAR(static_cast<double>(texel.y), 100'000, 50);  // V(555 nm) = 1
    EXPECT_EQ(texel.z, weighted(ratio[2]));
    const auto shifted = static_cast<std::uint64_t>(texel.y >> y_squared_shift);
    EXPECT_EQ(texel.y_squared, shifted * shifted);
    EXPECT_EQ(texel.hits, 1u);
    EXPECT_EQ(map.surfaces()[0][1][17], (BatchSums{100'000, texel.y, 1}));
    EXPECT_EQ(map.surfaces()[0][0][17], BatchSums{});
}

TEST(LightMap, NeitherOrderNorPackingChangesABit) {
    LoadedRun run = test::empty_run(test::sheet_scene(), small_job());
    std::vector<HitRecord> records = test::uniform_records(1, run.scene, 5'000);
    test::fill(run, records);
    const Digest expected = solution_digest(run.solution);

    std::shuffle(records.begin(), records.end(), std::mt19937_64(2));
    LightMap whole(run.layout), part(run.layout);
    KeptHits kept(run.solution.spec.keep_hits);
    for (std::size_t begin = 0; begin < records.size(); begin += 777) {
        const std::span<const HitRecord> some(records.data() + begin,
                                              std::min<std::size_t>(777, records.size() - begin));
        part.clear();
        part.add(run.emission, 0, some, {});
        const LightMap::Term once[] = {{&part}};
        whole.add(once);
        for (const HitRecord& hit : some) {
            const KeptHit candidate{hit, 0, run.emission.lights[0].energy[hit.wavelength]};
            if (keep_priority(candidate) <= kept.threshold()) kept.offer(candidate);
        }
    }
    run.solution.texels = whole.texels();
    run.solution.surfaces = whole.surfaces();
    run.solution.kept = kept.sorted();
    EXPECT_EQ(solution_digest(run.solution), expected);
}

TEST(SolutionDigest, ChangesWithWhatDecidesTheResultAndWithNothingElse) {
    LoadedRun run = test::empty_run(test::sheet_scene(), small_job());
    test::fill(run, test::uniform_records(1, run.scene, 500));
    const Digest digest = solution_digest(run.solution);

    Solution other = run.solution;
    other.time = {12, 34, 5};
    other.spec.name = "another name";
    other.spec.packing = Packing::maps;
    other.spec.strategy = Strategy::subspaces;
    other.spec.hits_per_message = 17;
    other.spec.particles_per_set = 1'000;
    other.spec.priority = 3;
    other.spec.cutoff = 0.5;  // means nothing to analog paths
    EXPECT_EQ(solution_digest(other), digest);

    const auto differs = [&](auto change) {
        Solution changed = run.solution;
        change(changed);
        return solution_digest(changed) != digest;
    };
    EXPECT_TRUE(differs([](Solution& s) { s.spec.seed = 2; }));
    EXPECT_TRUE(differs([](Solution& s) { s.spec.absorption = Absorption::attenuate; }));
    EXPECT_TRUE(differs([](Solution& s) { s.scene.bytes[31] ^= 1; }));
    EXPECT_TRUE(differs([](Solution& s) { s.texels[3].z += 1; }));
    EXPECT_TRUE(differs([](Solution& s) { s.surfaces[0][1][31].y += 1; }));
    EXPECT_TRUE(differs([](Solution& s) { s.kept[9].energy ^= 1; }));
    EXPECT_TRUE(differs([](Solution& s) { s.balance.emitted_by_batch[5] += 1; }));
    EXPECT_TRUE(differs([](Solution& s) { s.committed[0].insert(1'000'000, 1'000'001); }));
}

TEST(ValidRecord, RefusesIndicesBeyondTheScene) {
    const Scene scene = test::sheet_scene();
    HitRecord record;
    EXPECT_TRUE(valid_record(record, scene));
    record.triangle = 2;
    EXPECT_FALSE(valid_record(record, scene));
    record = {};
    record.wavelength = wavelength_bins;
    EXPECT_FALSE(valid_record(record, scene));
    record = {};
    record.b1 = 65'535;
    record.b2 = 1;
    EXPECT_TRUE(valid_record(record, scene));
    record.b2 = 2;
    EXPECT_FALSE(valid_record(record, scene));
}

TEST(KeptHits, KeepsTheLowestPrioritiesInWhateverOrderTheyCome) {
    const Scene scene = test::sheet_scene();
    std::vector<KeptHit> hits;
    for (const HitRecord& record : test::uniform_records(3, scene, 3'000)) hits.push_back({record, 0, 65'536});
    for (int i = 0; i < 20; ++i) hits.push_back(hits[i]);  // equal hits are hits too
    std::vector<KeptHit> expected = hits;
    std::stable_sort(expected.begin(), expected.end(),
                     [](const KeptHit& a, const KeptHit& b) { return keep_priority(a) < keep_priority(b); });
    for (const std::uint64_t capacity : {0ull, 1ull, 64ull, 5'000ull}) {
        KeptHits kept(capacity);
        std::shuffle(hits.begin(), hits.end(), std::mt19937_64(capacity));
        for (const KeptHit& hit : hits) kept.offer(hit);
        const auto sorted = kept.sorted();
        ASSERT_EQ(sorted.size(), std::min<std::uint64_t>(capacity, hits.size()));
        for (std::size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], expected[i]);
        if (capacity == 64) {
            EXPECT_EQ(kept.threshold(), keep_priority(sorted.back()));
        }
    }
}

TEST(KeptHits, AreAFairSampleOfAllHits) {
    // a fifth of the hits is of light 1: so is a fifth of those kept, within 4 standard errors
    const Scene scene = test::sheet_scene();
    KeptHits kept(4'000);
    std::uint32_t i = 0;
    for (const HitRecord& record : test::uniform_records(4, scene, 40'000)) kept.offer({record, ++i % 5 == 0, 65'536});
    const auto sample = kept.sorted();
    const auto ones = std::count_if(sample.begin(), sample.end(), [](const KeptHit& hit) { return hit.light == 1; });
    EXPECT_NEAR(static_cast<double>(ones), 800, 4 * std::sqrt(4'000 * 0.2 * 0.8));
}

}  // namespace
}  // namespace lumenfarm
