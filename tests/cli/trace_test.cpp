#include "cli/light_choice.h"
#include "cli/path_text.h"
#include "cli/traced_path.h"
#include "common/solution/surface_point.h"
#include "tests/scenes/scene_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>

#include <algorithm>
#include <tuple>
#include <utility>

namespace lumenfarm {
namespace {

using ::testing::HasSubstr;

/// A record and its energy, which can be sorted.
using Row = std::tuple<std::uint32_t, std::uint16_t, std::uint16_t, std::uint16_t, std::uint16_t, std::uint16_t,
                       std::uint16_t, std::uint32_t>;
Row row(const HitRecord& r, std::uint32_t energy) {
    return {r.triangle, r.b1, r.b2, r.direction_u, r.direction_v, r.wavelength, r.flags, energy};
}

class TracedPaths : public ::testing::TestWithParam<std::pair<Absorption, CutoffRule>> {
protected:
    TracedPaths() {
        spec_.absorption = GetParam().first;
        spec_.cutoff_rule = GetParam().second;
        spec_.cutoff = 0.3;
        spec_.seed = 5;
    }
    Scene scene_ = testing::mixed_room();
    std::unique_ptr<TracerScene> tracer_ = std::move(TracerScene::make(scene_).value());
    JobSpec spec_;
    static constexpr std::uint64_t first = 1'000, count = 300;
};

TEST_P(TracedPaths, HaveTheRecordsThatAWorkerSendsAndTheirBalance) {
    for (std::uint32_t light = 0; light < scene_.lights.size(); ++light) {
        TracedHits sent;
        tracer_->trace(spec_, {light, first, count}, sent);
        std::vector<Row> expected, rows;
        for (std::size_t i = 0; i < sent.records.size(); ++i)
            expected.push_back(row(sent.records[i], sent.energies.empty() ? 0 : sent.energies[i]));
        EnergyBalance balance;
        for (std::uint64_t particle = first; particle < first + count; ++particle) {
            const TracedPath path = trace_path(*tracer_, spec_, light, particle);
            for (const PathHit& hit : path.hits)
                rows.push_back(row(hit.record, sent.energies.empty() ? 0 : hit.energy));
            balance += path.balance;
        }
        std::ranges::sort(expected);
        std::ranges::sort(rows);
        EXPECT_EQ(rows, expected);
        EXPECT_EQ(balance, sent.balance);
        EXPECT_TRUE(balance.closed());
    }
}

TEST_P(TracedPaths, BookEveryTickOfAPathWhereItWent) {
    for (std::uint64_t particle = first; particle < first + count; ++particle) {
        const TracedPath path = trace_path(*tracer_, spec_, 0, particle);
        std::int64_t absorbed = 0, cut_off = 0;
        std::int64_t carried = path.energy;
        for (const PathHit& hit : path.hits) {
            EXPECT_EQ(hit.energy, carried);
            absorbed += hit.absorbed;
            cut_off += hit.cut_off;
            carried -= hit.absorbed + hit.cut_off;
        }
        EXPECT_EQ(absorbed, path.balance.absorbed);
        EXPECT_EQ(cut_off, path.balance.cut_off);
        EXPECT_EQ(carried, path.balance.escaped);
        EXPECT_EQ(path.escaped.has_value(), path.balance.escaped > 0);
    }
}

TEST_P(TracedPaths, GoFromHitToHitAndSayHowEachEnds) {
    std::array<int, 5> fates{};
    for (std::uint64_t particle = first; particle < first + count; ++particle) {
        const TracedPath path = trace_path(*tracer_, spec_, 1, particle);
        Vec3d from = path.position;
        for (std::size_t i = 0; i < path.hits.size(); ++i) {
            const PathHit& hit = path.hits[i];
            ++fates[static_cast<std::size_t>(hit.fate)];
            EXPECT_EQ(hit.record.bounce(), i);
            const bool goes_on = hit.fate == HitFate::reflected || hit.fate == HitFate::transmitted;
            EXPECT_EQ(goes_on, i + 1 < path.hits.size() || path.escaped.has_value());
            // packed barycentrics are good to 1/65,536 of an edge of at most a metre and a half
            const Vec3d at = position_of(scene_, hit.record);
            const Vec3d along = from + hit.direction * dot(at - from, hit.direction);
            EXPECT_LT(length(at - along), 1e-4);
            from = at;
        }
    }
    const auto seen = [&](HitFate fate) { return fates[static_cast<std::size_t>(fate)] > 0; };
    EXPECT_TRUE(seen(HitFate::reflected));
    EXPECT_TRUE(seen(HitFate::transmitted)) << "through the glass ball";
    EXPECT_EQ(seen(HitFate::absorbed), spec_.absorption == Absorption::analog);
    EXPECT_EQ(seen(HitFate::cut_off), spec_.absorption == Absorption::attenuate);
}

INSTANTIATE_TEST_SUITE_P(Rules, TracedPaths,
                         ::testing::Values(std::pair(Absorption::analog, CutoffRule::roulette),
                                           std::pair(Absorption::attenuate, CutoffRule::roulette),
                                           std::pair(Absorption::attenuate, CutoffRule::plain)),
                         [](const auto& tested) {
                             const bool analog = tested.param.first == Absorption::analog;
                             const bool plain = tested.param.second == CutoffRule::plain;
                             return std::string(analog ? "Analog" : plain ? "AttenuatePlain" : "AttenuateRoulette");
                         });

TEST(TracedPath, EscapesFromAnOpenScene) {
    testing::SceneBuilder b;
    b.surface("floor", b.lambert(0.5));
    b.quad({0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0});
    b.point_light({0.5, 1, 0.5}, 10);
    const auto tracer = std::move(TracerScene::make(b.scene).value());
    int straight = 0;
    for (std::uint64_t particle = 0; particle < 64; ++particle) {
        const TracedPath path = trace_path(*tracer, JobSpec(), 0, particle);
        if (!path.hits.empty()) continue;
        ++straight;
        ASSERT_TRUE(path.escaped);
        EXPECT_EQ(*path.escaped, path.direction);
        EXPECT_EQ(path.position, (Vec3d{0.5, 1, 0.5}));
        EXPECT_THAT(path_text(b.scene, path), HasSubstr("escapes "));
    }
    EXPECT_GT(straight, 0);
}

TEST(TracedPath, TextNamesWhatIsMetAndTheDocumentHoldsTheRecord) {
    const Scene scene = testing::mixed_room();
    const auto tracer = std::move(TracerScene::make(scene).value());
    TracedPath path;
    for (std::uint64_t particle = 0; path.hits.size() < 2; ++particle)
        path = trace_path(*tracer, JobSpec(), 0, particle);
    const std::string text = path_text(scene, path);
    EXPECT_THAT(text, HasSubstr("particle " + std::to_string(path.particle) + ": "));
    EXPECT_THAT(text, HasSubstr(" nm\n  start "));
    EXPECT_THAT(text, HasSubstr(scene.surfaces[path.hits[0].surface].name + " ("));
    EXPECT_EQ(std::ranges::count(text, '\n'),
              static_cast<std::ptrdiff_t>(2 + path.hits.size() + path.escaped.has_value()));
    const auto document = path_document(scene, path);
    const auto& hit = document.at("hits").at(1).as_object();
    EXPECT_EQ(hit.at("bounce").to_number<std::uint32_t>(), 1u);
    EXPECT_EQ(hit.at("record").at("b1").to_number<std::uint32_t>(), path.hits[1].record.b1);
    EXPECT_EQ(hit.at("record").at("flags").to_number<std::uint32_t>(), path.hits[1].record.flags);
    EXPECT_EQ(hit.at("energy_ticks").to_number<std::uint32_t>(), path.energy);
}

TEST(LightChoice, IsANameOrANumberAndOtherwiseSaysWhatThereIs) {
    testing::SceneBuilder b;
    for (int i = 0; i < 12; ++i) b.point_light({0, 0, 0}, 1);
    b.scene.lights[0].name = "lamp";
    b.scene.lights[1].name = "7";
    EXPECT_EQ(choose_light(b.scene, "lamp").value(), 0u);
    EXPECT_EQ(choose_light(b.scene, "3").value(), 3u);
    EXPECT_EQ(choose_light(b.scene, "7").value(), 1u) << "a name goes before a number";
    const auto many = choose_light(b.scene, "point");
    ASSERT_FALSE(many);
    EXPECT_THAT(many.error().sentence, HasSubstr("several lights are called 'point'; say the number: 2 'point', 3"));
    for (const char* wrong : {"12", "moon", "-1", ""}) {
        const auto none = choose_light(b.scene, wrong);
        ASSERT_FALSE(none) << wrong;
        EXPECT_EQ(none.error().code, ErrorCode::bad_input);
        EXPECT_THAT(none.error().sentence, HasSubstr("it has 0 'lamp', 1 '7', 2 'point'"));
        EXPECT_THAT(none.error().sentence, HasSubstr("and 2 more"));
    }
}

}  // namespace
}  // namespace lumenfarm
