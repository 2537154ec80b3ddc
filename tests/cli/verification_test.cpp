#include "cli/verification.h"
#include "tests/scenes/scene_builder.h"
#include "tests/solution/traced_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <utility>

namespace lumenfarm {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Verifying : public ::testing::TestWithParam<Absorption> {
protected:
    Verifying() : run_(test::traced_run(testing::mixed_room(), spec())) {
        tracer_ = std::move(TracerScene::make(run_.scene).value());
    }
    static JobSpec spec() {
        JobSpec spec;
        spec.particles = 20'000;
        spec.keep_hits = 700;
        spec.texel_m = 0.3;
        spec.absorption = GetParam();
        return spec;
    }
    Verification verified(std::vector<std::uint32_t> batches) const {
        return verify(run_, *tracer_, std::move(batches), 2, [](double) {});
    }
    static std::vector<std::uint32_t> all() {
        std::vector<std::uint32_t> batches(limits::batches);
        std::iota(batches.begin(), batches.end(), 0u);
        return batches;
    }
    SurfaceBatches& some_surface() {
        return *std::find_if(run_.solution.surfaces.begin(), run_.solution.surfaces.end(),
                             [](const SurfaceBatches& surface) { return surface[0][4].hits > 0; });
    }

    LoadedRun run_;
    std::unique_ptr<TracerScene> tracer_;
};

TEST_P(Verifying, HonestResultAgreesInPartAndWhole) {
    const Verification part = verified({4, 9});
    EXPECT_THAT(part.differences, IsEmpty());
    EXPECT_NEAR(static_cast<double>(part.particles), 20'000.0 * 2 / 32, 130);
    const Verification whole = verified(all());
    EXPECT_THAT(whole.differences, IsEmpty());
    EXPECT_EQ(whole.particles, 20'000u);
    EXPECT_EQ(whole.hits, run_.solution.balance.hits);
}

TEST_P(Verifying, OneTickOfASurfaceShowsInItsBatch) {
    ++some_surface()[0][4].radiant;
    EXPECT_THAT(verified({4}).differences, ElementsAre(HasSubstr("(front)")));
    EXPECT_THAT(verified({5}).differences, IsEmpty());
}

TEST_P(Verifying, ChangedOrMissingKeptHitShows) {
    const std::uint32_t batch = run_.solution.kept[100].record.batch();
    run_.solution.kept[100].record.direction_u ^= 1;
    EXPECT_THAT(verified({batch}).differences, ElementsAre(HasSubstr("hits of these particles are kept")));
    run_.solution.kept.erase(run_.solution.kept.begin() + 100);
    EXPECT_THAT(verified({batch}).differences, ElementsAre(HasSubstr("hits of these particles are kept")));
}

TEST_P(Verifying, TexelShowsInTheWhole) {
    const auto texel = std::find_if(run_.solution.texels.begin(), run_.solution.texels.end(),
                                    [](const TexelSums& sums) { return sums.hits > 0; });
    ++texel->x;
    EXPECT_THAT(verified({4}).differences, IsEmpty());
    EXPECT_THAT(verified(all()).differences, ElementsAre("the sums of 1 texel are not those of the particles"));
}

TEST_P(Verifying, ParticlesThatAreSaidToBeThereAreTraced) {
    auto& committed = run_.solution.committed[0];
    const std::uint64_t end = committed.size();
    ASSERT_TRUE(committed.insert(end, end + 1'000));
    EXPECT_FALSE(verified(all()).differences.empty());
}

INSTANTIATE_TEST_SUITE_P(Absorptions, Verifying, ::testing::Values(Absorption::analog, Absorption::attenuate));

}  // namespace
}  // namespace lumenfarm
