#include "cli/products/camera_choice.h"
#include "cli/products/inspect.h"
#include "cli/products/inspect_octree.h"
#include "cli/products/json_text.h"
#include "cli/products/pictures.h"
#include "common/support/file.h"
#include "tests/solution/synthetic.h"
#include "tests/solution/traced_run.h"

#include <gtest/gtest.h>
#include <boost/json.hpp>

#include <cmath>
#include <filesystem>

namespace lumenfarm {
namespace {

namespace json = boost::json;

Scene room_scene() {
    test::QuadScene quads;
    quads.room({4, 3, 5}, quads.lambert(0.5));
    quads.point_light({2, 2.5, 2}, 100, false);
    return quads.scene;
}

JobSpec job(std::uint64_t particles) {
    JobSpec spec;
    spec.particles = particles;
    return spec;
}

TEST(JsonText, IsValidJsonAndKeepsEveryBit) {
    const json::object object{
        {"a", 0.1}, {"b", std::nan("")}, {"c", {1, true, nullptr, "q\"\n"}}, {"d", json::object{}}};
    const json::value read = json::parse(json_text(object));
    EXPECT_EQ(read.at("a").as_double(), 0.1);
    EXPECT_TRUE(read.at("b").is_null());
    EXPECT_EQ(read.at("c").as_array().size(), 4u);
    EXPECT_EQ(read.at("c").at(3).as_string(), "q\"\n");
}

TEST(Inspect, DocumentHoldsTheContract) {
    const LoadedRun run = test::traced_run(room_scene(), job(20'000));
    const json::value document = json::parse(json_text(inspect_document(run)));
    EXPECT_EQ(document.at("digest").as_string(), solution_digest(run.solution).hex());
    EXPECT_EQ(document.at("scene").as_string(), run.scene_name.hex());
    EXPECT_EQ(document.at("particles").to_number<std::uint64_t>(), 20'000u);
    EXPECT_EQ(document.at("hits").to_number<std::uint64_t>(), run.solution.balance.hits);
    const json::value& balance = document.at("balance");
    EXPECT_TRUE(balance.at("ticks_equal").as_bool());
    const double emitted = balance.at("emitted_w").to_number<double>();
    EXPECT_NEAR(balance.at("absorbed_w").to_number<double>() + balance.at("escaped_w").to_number<double>() +
                    balance.at("cutoff_w").to_number<double>(),
                emitted, 1e-9 * emitted);
    EXPECT_NEAR(emitted, run.emission.flux_w, 0.02 * emitted);
    const json::value& light = document.at("lights").at(0);
    EXPECT_EQ(light.at("name").as_string(), "lamp 0");
    EXPECT_NEAR(light.at("flux_lm").to_number<double>(), 4 * 3.14159265358979323846 * 100, 1e-6);
    EXPECT_GT(light.at("flux_w").to_number<double>(), 0);
    EXPECT_EQ(light.at("particles").to_number<std::uint64_t>(), 20'000u);
    ASSERT_EQ(document.at("surfaces").as_array().size(), 6u);
    const json::value& floor = document.at("surfaces").at(0);
    EXPECT_EQ(floor.at("name").as_string(), "floor");
    EXPECT_EQ(floor.at("object").as_string(), "floor");
    EXPECT_NEAR(floor.at("area_m2").to_number<double>(), 20, 1e-6);
    for (const char* field : {"hits", "irradiance_w_m2", "illuminance_lx", "relative_error"})
        EXPECT_GT(floor.at(field).to_number<double>(), 0) << field;
    EXPECT_TRUE(floor.at("back").at("relative_error").is_null());
    for (const char* field : {"total_s", "trace_s", "workers"})
        EXPECT_TRUE(document.at("time").as_object().contains(field));
}

TEST(Inspect, TableNamesEverySurface) {
    const LoadedRun run = test::traced_run(room_scene(), job(1'000));
    const std::string table = inspect_table(run);
    for (const char* part : {"floor", "ceiling", "south", "lamp 0", "1000 of 1000"})
        EXPECT_NE(table.find(part), std::string::npos) << part;
}

TEST(Inspect, OctreeIsShownWithTheCellsOfItsLights) {
    const Scene scene = room_scene();
    const std::vector<double> shares{1.0};
    const OctreeSummary summary = summarize(scene, make_weighted_octree(scene, {}, shares));
    const json::value document = json::parse(json_text(octree_document(summary)));
    EXPECT_EQ(document.at("triangles").to_number<int>(), 12);
    EXPECT_EQ(document.at("lights").at(0).at("light").as_string(), "lamp 0");
    EXPECT_NE(octree_table(summary).find("lamp 0"), std::string::npos);
}

TEST(Cameras, AreChosenByNameByPlaceOrByFraming) {
    Scene scene = room_scene();
    const auto tracer = TracerScene::make(scene);
    const auto choose = [&](const ViewRequest& request) { return choose_camera(scene, **tracer, request); };
    const auto inside = choose({});
    ASSERT_TRUE(inside);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_GT(inside->position[axis], 0);
        EXPECT_LT(inside->position[axis], (Vec3d{4, 3, 5})[axis]) << "a closed room is seen from within";
    }
    const auto placed = choose({{}, Vec3d{1, 1, 1}, Vec3d{1, 1, 0}, 50.0});
    ASSERT_TRUE(placed);
    EXPECT_EQ(placed->forward, (Vec3d{0, 0, -1}));
    EXPECT_EQ(placed->vertical_fov_degrees, 50);
    EXPECT_FALSE(choose({"nobody", {}, {}, {}}));
    EXPECT_FALSE(choose({{}, Vec3d{1, 1, 1}, {}, {}}));
    EXPECT_FALSE(choose({{}, Vec3d{1, 1, 1}, Vec3d{1, 1, 1}, {}}));
    EXPECT_FALSE(choose({{}, {}, {}, 180.0}));
    Camera camera;
    camera.name = "door";
    scene.cameras = {camera};
    EXPECT_EQ(choose({})->name, "door");
    EXPECT_EQ(choose({"door", {}, {}, {}})->name, "door");
    const auto unknown = choose({"window", {}, {}, {}});
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().sentence.find("'door'"), std::string::npos);
}

TEST(Cameras, AnOpenBoxIsSeenThroughItsOpenSide) {
    Scene scene = room_scene();
    scene.triangles.resize(10);  // no south wall
    scene.surfaces.pop_back();
    const auto tracer = TracerScene::make(scene);
    const Camera camera = framing_camera(scene, **tracer);
    EXPECT_GT(camera.position.z, 5);
    EXPECT_LT(camera.forward.z, 0);
}

TEST(PictureSize, IsReadStrictly) {
    const auto size = parse_picture_size("640x480");
    ASSERT_TRUE(size);
    EXPECT_EQ(size->width, 640u);
    EXPECT_EQ(size->height, 480u);
    for (const char* bad : {"", "640", "x", "640x", "0x10", "10x0", "-4x4", "4x4x4", "99999x1", "1e3x10", "640X480 "})
        EXPECT_FALSE(parse_picture_size(bad)) << bad;
    EXPECT_EQ(default_picture_size(2).height, 400u);
    EXPECT_EQ(default_picture_size(0.5).width, 400u);
    EXPECT_EQ(default_picture_size(std::nan("")).width, 800u);
}

TEST(Products, ARunLeavesPicturesOfEachCameraAndAReport) {
    Scene scene = room_scene();
    Camera camera;
    camera.position = {2, 1, 4.5};
    camera.name = "../north view";
    scene.cameras = {camera, camera};
    const LoadedRun run = test::traced_run(scene, job(20'000));
    const auto tracer = TracerScene::make(run.scene);
    const auto folder = std::filesystem::path(testing::TempDir()) / "lumenfarm_products";
    std::filesystem::create_directories(folder);
    const auto made = write_products(run, **tracer, folder, {PictureSize{32, 24}, 1, 1, Estimator::automatic});
    ASSERT_TRUE(made) << made.error().sentence;
    EXPECT_EQ(*made, (std::vector<std::string>{"___north_view.png", "___north_view.exr", "___north_view-2.png",
                                               "___north_view-2.exr"}));
    for (const std::string& name : *made) EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
    const auto report = read_file(folder / "report.json", 1 << 20);
    ASSERT_TRUE(report);
    const json::value document =
        json::parse(std::string(reinterpret_cast<const char*>(report->data()), report->size()));
    EXPECT_EQ(document.at("pictures").as_array().size(), 4u);
    EXPECT_EQ(document.at("job").at("particles").to_number<int>(), 20'000);
    EXPECT_FALSE(render_to(run, **tracer, camera, {}, folder / "view.gif"));
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace lumenfarm
