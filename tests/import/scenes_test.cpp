#include "common/scene/scene_file.h"
#include "tests/import/files.h"

#include <algorithm>
#include <cstdlib>
#include <random>

namespace lumenfarm {
namespace {

std::filesystem::path own(const std::string& name) {
    return std::filesystem::path(LUMENFARM_SOURCE_DIR) / "scenes" / name;
}

ImportedScene import_own(const std::string& name) {
    auto result = import_scene(own(name), {});
    EXPECT_TRUE(result) << result.error().sentence;
    EXPECT_TRUE(!result || result->warnings.empty());
    return result ? *result : ImportedScene{};
}

TEST(OwnScenes, CornellBoxHasRedAtTheLeftAndGreenAtTheRightOfItsPicture) {
    const Scene scene = import_own("cornell.gltf").scene;
    ASSERT_EQ(scene.cameras.size(), 1u);
    const Camera& camera = scene.cameras[0];
    EXPECT_EQ(camera.name, "camera");
    EXPECT_NEAR(camera.vertical_fov_degrees, 39.3, 1e-9);
    const Vec3d right = cross(camera.forward, camera.up);
    const auto side = [&](const std::string& name) {
        for (const Surface& surface : scene.surfaces)
            if (surface.name == name)
                return dot(right,
                           scene.positions[scene.triangles[surface.first_triangle][0]].as<double>() - camera.position);
        return 0.0;
    };
    EXPECT_LT(side("left wall"), -0.2);
    EXPECT_GT(side("right wall"), 0.2);
    EXPECT_EQ(scene.materials[2].name, "red");
    EXPECT_FLOAT_EQ(scene.spectra[scene.materials[2].diffuse.spectrum].samples[64], 0.642f);  // 700 nm
}

TEST(OwnScenes, CornellLampShinesDown) {
    const Scene scene = import_own("cornell.gltf").scene;
    ASSERT_EQ(scene.lights.size(), 1u);
    const std::uint32_t triangle = scene.surfaces[scene.lights[0].surface].first_triangle;
    EXPECT_LT(triangle_cross(scene, triangle).y, 0);
    EXPECT_NEAR(2 * triangle_area_m2(scene, triangle), 0.13 * 0.105, 1e-7);
    EXPECT_FLOAT_EQ(scene.spectra[scene.lights[0].spectrum].samples[24], 8.0f);  // 500 nm
}

TEST(OwnScenes, PaperRoomHas17SurfacesAnd2Lights) {
    const Scene scene = import_own("paper_room.gltf").scene;
    EXPECT_EQ(scene.surfaces.size(), 17u);
    EXPECT_EQ(scene.lights.size(), 2u);
    const auto mirrors = std::count_if(scene.materials.begin(), scene.materials.end(),
                                       [](const Material& m) { return m.mirror.spectrum != none; });
    EXPECT_EQ(mirrors, 1);
    for (const char* object : {"box", "cylinder", "ball"})
        EXPECT_TRUE(std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [&](const Surface& s) {
            return s.object == object;
        })) << object;
}

TEST(OwnScenes, PrismAndBallAreSolidDispersiveGlass) {
    const Scene scene = import_own("prism.gltf").scene;
    int glasses = 0;
    for (const Material& m : scene.materials) {
        if (m.dielectric == 0) continue;
        ++glasses;
        EXPECT_FALSE(m.thin);
        const auto& n = scene.spectra[m.refractive_index].samples;
        EXPECT_GT(n[4] - n[64], 0.015f);
    }
    EXPECT_EQ(glasses, 2);
    for (const Surface& surface : scene.surfaces)
        EXPECT_TRUE(surface.name != "ball" || surface.triangle_count >= 5'000u);
}

TEST(SharedScenes, EachIsImportedOrRefusedInASentence) {
    const char* given = std::getenv("LUMENFARM_SHARED_SCENES");
    const std::filesystem::path folder =
        given != nullptr ? given : std::filesystem::path(LUMENFARM_SOURCE_DIR) / ".." / "shared" / "scenes";
    if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
    int imported = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const std::string extension = entry.path().extension();
        if (extension != ".obj" && extension != ".gltf" && extension != ".glb") continue;
        const auto plain = import_scene(entry.path(), {});
        if (!plain) {
            EXPECT_FALSE(plain.error().sentence.empty()) << entry.path();
            continue;
        }
        ++imported;
        const auto lit = import_scene(entry.path(), {true, 1, 1});
        ASSERT_TRUE(lit) << lit.error().sentence;
        EXPECT_TRUE(require_light(lit->scene)) << entry.path();
        EXPECT_TRUE(decode_scene(encode_scene(lit->scene))) << entry.path();
    }
    EXPECT_GT(imported, 0);
}

/// `rounds` files with a few bytes changed: each is imported as a valid scene or refused.
void import_mutants(const std::string& name, const std::string& text, int rounds) {
    const test::ImportFolder folder;
    folder.write("mesh.bin", test::square_bin());
    folder.write("scene.mtl", "newmtl m\nKd 1 1 1\nmap_Kd picture.png\n");
    folder.write("picture.png", test::tiny_png());
    std::mt19937_64 random(11);
    for (int round = 0; round < rounds; ++round) {
        std::string mutant = text;
        for (std::uint64_t changes = 1 + random() % 3; changes > 0; --changes) {
            const std::uint64_t at = random() % mutant.size();
            if (random() % 3 == 0)
                mutant.erase(at, random() % 8);
            else
                mutant[at] = random() % 2 == 0 ? mutant[random() % mutant.size()] : static_cast<char>(random());
            if (mutant.empty()) mutant = " ";
        }
        const auto result = import_scene(folder.write(name, mutant), {});
        if (result) {
            ASSERT_TRUE(validate(result->scene));
        } else {
            ASSERT_EQ(result.error().code, ErrorCode::bad_input) << result.error().sentence;
        }
    }
}

TEST(Mutants, OfGltfNeverCrash) { import_mutants("m.gltf", test::square_gltf, 700); }

TEST(Mutants, OfGlbNeverCrash) {
    import_mutants("m.glb",
                   test::glb(test::replaced(test::square_gltf, R"("uri": "mesh.bin", )", ""), test::square_bin()), 700);
}

TEST(Mutants, OfObjNeverCrash) {
    import_mutants("m.obj",
                   "mtllib scene.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nusemtl m\nf 1/1 2/1 3/1\ng b c\n"
                   "f -3 -2 -1\n",
                   700);
}

}  // namespace
}  // namespace lumenfarm
