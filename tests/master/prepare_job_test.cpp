#include "common/scene/scene_file.h"
#include "master/job.h"
#include "tests/scenes/scene_builder.h"

#include <gtest/gtest.h>

namespace lumenfarm {
namespace {

TEST(PreparedJob, PredictsThatLightInTheMidstOfDetailCostsMore) {
    testing::SceneBuilder b;
    const std::uint32_t white = b.lambert(0.5);
    b.box("hall", {0, 0, 0}, {10, 10, 10}, white, true);
    b.sphere("detail", {2, 2, 2}, 1, 60, white);
    b.point_light({2, 3.5, 2}, 100);
    b.point_light({8, 8, 8}, 300);
    const auto prepared = prepare_job(JobSpec(), encode_scene(b.scene)).value();
    const auto& costs = prepared->light_costs;
    ASSERT_EQ(costs.size(), 2u);
    EXPECT_GT(costs[0], 1.3 * costs[1]);
    EXPECT_NEAR((costs[0] + 3 * costs[1]) / 4, 1, 1e-6) << "over all particles";
}

}  // namespace
}  // namespace lumenfarm
