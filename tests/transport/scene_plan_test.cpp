#include "common/transport/scene_plan.h"

#include "common/scene/scene_file.h"
#include "tests/scenes/planned_scene.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace lumenfarm::testing {
namespace {

TEST(ScenePlan, PaletteIsAValidSceneWithAllThatEmits) {
    const Scene scene = mixed_room();
    const ScenePart palette = palette_of(scene);
    EXPECT_TRUE(validate(palette.scene));
    EXPECT_EQ(palette.scene.surfaces.size(), scene.surfaces.size());
    EXPECT_LT(palette.scene.triangles.size(), scene.triangles.size());
    for (const Light& light : scene.lights)
        if (light.kind == LightKind::surface) {
            EXPECT_EQ(palette.scene.surfaces[light.surface].triangle_count,
                      scene.surfaces[light.surface].triangle_count);
        }
    for (std::uint32_t t = 0; t < palette.numbers.size(); ++t)
        for (std::size_t corner = 0; corner < 3; ++corner)
            EXPECT_EQ(palette.scene.positions[palette.scene.triangles[t][corner]],
                      scene.positions[scene.triangles[palette.numbers[t]][corner]]);
}

TEST(ScenePlan, ComesBackFromItsBytes) {
    const PlannedScene planned(8);
    const auto back = decode_plan(encode_plan(planned.plan));
    ASSERT_TRUE(back) << back.error().sentence;
    EXPECT_EQ(*back, planned.plan);
}

TEST(ScenePlan, PartsComeBackFromTheirBytes) {
    const PlannedScene planned(8);
    for (std::uint32_t s = 0; s < planned.plan.partition.subspaces(); ++s) {
        const ScenePart part = planned.parts[s];
        const auto back = decode_part(encode_part(part), planned.plan);
        ASSERT_TRUE(back) << back.error().sentence;
        EXPECT_EQ(*back, part);
    }
}

TEST(ScenePlan, EveryCutIsRefused) {
    const PlannedScene planned(8);
    const auto plan = encode_plan(planned.plan);
    for (std::size_t bytes = 0; bytes < plan.size(); bytes += 7)
        EXPECT_FALSE(decode_plan(std::span(plan).first(bytes))) << bytes;
    const auto part = encode_part(planned.parts[0]);
    for (std::size_t bytes = 0; bytes < part.size(); bytes += 7)
        EXPECT_FALSE(decode_part(std::span(part).first(bytes), planned.plan)) << bytes;
}

TEST(ScenePlan, WhatContradictsItselfIsRefused) {
    const std::vector<std::function<void(ScenePlan&)>> spoil{
        [](ScenePlan& plan) { plan.parts.pop_back(); },
        [](ScenePlan& plan) { plan.whole.triangles += 1; },
        [](ScenePlan& plan) { plan.whole.bytes = ~std::uint64_t{0}; },
        [](ScenePlan& plan) { plan.first_triangle.back() += 1; },
        [](ScenePlan& plan) { plan.first_triangle[1] = 0; },
        [](ScenePlan& plan) { plan.palette.numbers[1] = 0; },
        [](ScenePlan& plan) { plan.texel_rows[2] = 0; },
        [](ScenePlan& plan) { plan.texel_rows.pop_back(); },
        [](ScenePlan& plan) { plan.extent.half_m = -1; },
        [](ScenePlan& plan) { plan.parts[0].triangles = 1'000'000; },
        [](ScenePlan& plan) {
            std::vector<Partition::Node> nodes(plan.partition.nodes().begin(), plan.partition.nodes().end());
            nodes[0].first = 0;  // its own child
            plan.partition = Partition(nodes);
        },
        [](ScenePlan& plan) {
            std::vector<Partition::Node> nodes(plan.partition.nodes().begin(), plan.partition.nodes().end());
            nodes.pop_back();
            plan.partition = Partition(nodes);
        },
    };
    for (std::size_t i = 0; i < spoil.size(); ++i) {
        PlannedScene planned(8);
        spoil[i](planned.plan);
        EXPECT_FALSE(decode_plan(encode_plan(planned.plan))) << i;
    }
}

TEST(ScenePlan, PartWithImpossibleTrianglesIsRefused) {
    const PlannedScene planned(8);
    const std::vector<std::function<void(ScenePart&)>> spoil{
        [](ScenePart& part) { part.scene.triangles[0][0] = 1'000'000; },
        [](ScenePart& part) { part.scene.triangles[0][1] = part.scene.triangles[0][0]; },
        [](ScenePart& part) { part.numbers.back() = 1'000'000; },
        [](ScenePart& part) { part.numbers[1] = part.numbers[0]; },
        [](ScenePart& part) { part.scene.positions[0].x = 1e9f; },
        [](ScenePart& part) { part.scene.uvs.resize(1); },
    };
    for (std::size_t i = 0; i < spoil.size(); ++i) {
        ScenePart part = planned.parts[0];
        spoil[i](part);
        EXPECT_FALSE(decode_part(encode_part(part), planned.plan)) << i;
    }
}

}  // namespace
}  // namespace lumenfarm::testing
