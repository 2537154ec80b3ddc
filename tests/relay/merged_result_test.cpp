#include "relay/merged_result.h"

#include "common/scene/scene_file.h"
#include "tests/simulation/small_scene.h"

#include <gtest/gtest.h>

namespace lumenfarm::relay {
namespace {

TEST(MergedResult, AddsUpTheWorkInSubspaces) {
    JobSpec spec;
    spec.strategy = Strategy::subspaces;
    spec.subspaces = 6;
    const auto prepared = prepare_job(spec, encode_scene(testing::small_scene())).value();
    MergedResult merged(1, spec, prepared);
    const auto add = [&](std::vector<SubspaceWork> work) {
        StagedResult result(1, 1);
        result.add(spec, *prepared, wire::ResultWork({1, 1, 0}, std::move(work)));
        ASSERT_TRUE(result.complete(*prepared, wire::ResultDone(1, 1, {}, 1, {}, 0, 0)));
        merged.add(result, {});
    };
    add({{0, 0, 5}, {4, 0, 1'000}});
    add({{4, 0, 300}, {5, 0, 2}});
    const Parcel parcel = merged.take();
    ParcelReader reader(parcel, 7);
    EXPECT_EQ(std::get<wire::ResultWork>(*reader.next()),
              wire::ResultWork({1, 7, 0}, {{0, 0, 5}, {4, 0, 1'300}, {5, 0, 2}}));
    EXPECT_TRUE(merged.take().work.empty());
}

}  // namespace
}  // namespace lumenfarm::relay
