#include "tests/loopback/farm_fixture.h"

#include <gtest/gtest.h>

#include <array>
#include <tuple>

/// `lumenfarm trace`: what a job does with a set, shown.
namespace lumenfarm::testing {
namespace {

class TraceCommand : public Farm {};

TEST_F(TraceCommand, DocumentHoldsTheRecordsOfTheSetAndItsBalance) {
    const std::vector<std::string> command{"trace",  scene_, "--light",      "lamp",      "--particles", "2000..2099",
                                           "--seed", "3",    "--absorption", "attenuate", "--json"};
    const auto document = json(command);
    EXPECT_EQ(document.at("light").at("name").as_string(), "lamp");
    EXPECT_EQ(document.at("scene").as_string(), scene_digest(encode_scene(mixed_room())).hex());
    EXPECT_TRUE(document.at("balance").at("ticks_equal").as_bool());

    const Scene scene = mixed_room();
    JobSpec spec;
    spec.seed = 3;
    spec.absorption = Absorption::attenuate;
    TracedHits sent;
    const auto tracer = std::move(TracerScene::make(scene).value());
    tracer->trace(spec, {0, 2'000, 100}, sent);
    using Row = std::array<std::uint64_t, 8>;
    std::vector<Row> expected, printed;
    for (std::size_t i = 0; i < sent.records.size(); ++i) {
        const HitRecord& r = sent.records[i];
        expected.push_back(
            {r.triangle, r.b1, r.b2, r.direction_u, r.direction_v, r.wavelength, r.flags, sent.energies[i]});
    }
    const auto& paths = document.at("paths").as_array();
    ASSERT_EQ(paths.size(), 100u);
    EXPECT_EQ(paths.front().at("particle").to_number<std::uint64_t>(), 2'000u);
    for (const auto& path : paths)
        for (const auto& hit : path.at("hits").as_array()) {
            const auto number = [](const boost::json::value& value) { return value.to_number<std::uint64_t>(); };
            const auto& r = hit.at("record");
            printed.push_back({number(hit.at("triangle")), number(r.at("b1")), number(r.at("b2")),
                               number(r.at("direction_u")), number(r.at("direction_v")), number(r.at("wavelength")),
                               number(r.at("flags")), number(hit.at("energy_ticks"))});
        }
    std::ranges::sort(expected);
    std::ranges::sort(printed);
    EXPECT_EQ(printed, expected);
    EXPECT_EQ(document.at("balance").at("emitted_ticks").to_number<std::int64_t>(), sent.balance.emitted);
}

TEST_F(TraceCommand, TextEndsWithTheBalance) {
    const std::string text = lumenfarm({"trace", scene_, "--light", "1", "--particles", "7"});
    EXPECT_TRUE(text.starts_with("scene ")) << text;
    EXPECT_NE(text.find("light 1 'point'"), std::string::npos) << text;
    EXPECT_NE(text.find("\nparticle 7: "), std::string::npos) << text;
    EXPECT_NE(text.find("\n1 particle, "), std::string::npos) << text;
    EXPECT_NE(text.find(" emitted = "), std::string::npos) << text;
}

}  // namespace
}  // namespace lumenfarm::testing
