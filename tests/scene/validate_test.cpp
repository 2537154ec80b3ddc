#include "common/scene/scene_file.h"
#include "common/scene/text.h"
#include "tests/scene/sample_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace lumenfarm {
namespace {

struct Fault {
    const char* name;
    std::function<void(Scene&)> make;
    const char* says;  ///< part of the sentence
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

class FaultyScene : public testing::TestWithParam<Fault> {};

TEST_P(FaultyScene, IsRefusedWithItsElement) {
    Scene scene = test::sample_scene();
    GetParam().make(scene);
    const auto result = validate(scene);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::bad_input);
    EXPECT_NE(result.error().sentence.find(GetParam().says), std::string::npos) << result.error().sentence;
    EXPECT_FALSE(decode_scene(encode_scene(scene)));
}

const Fault faults[] = {
    {"NanPosition", [](Scene& s) { s.positions[1].y = nan; }, "vertex 1"},
    {"InfinitePosition", [](Scene& s) { s.positions[2].x = infinity; }, "vertex 2"},
    {"FarPosition", [](Scene& s) { s.positions[2].x = 2e7f; }, "2e+07"},
    {"MissingUvs", [](Scene& s) { s.uvs.pop_back(); }, "4 texture coordinates"},
    {"NanUv", [](Scene& s) { s.uvs[3].x = nan; }, "vertex 3"},
    {"TextureWithoutUvs", [](Scene& s) { s.uvs.clear(); }, "no texture coordinates"},
    {"NoTriangles", [](Scene& s) { s.triangles.clear(); }, "no triangles"},
    {"IndexOutOfRange", [](Scene& s) { s.triangles[1][2] = 5; }, "vertex 5 of 5"},
    {"ZeroArea",
     [](Scene& s) {
         s.triangles[1] = {0, 1, 1};
     },
     "triangle 1 has zero area"},
    {"SurfaceGap", [](Scene& s) { s.surfaces[1].first_triangle = 1; }, "surface 1"},
    {"SurfaceShort", [](Scene& s) { s.surfaces.pop_back(); }, "2 triangles and the scene 3"},
    {"SurfaceHuge", [](Scene& s) { s.surfaces[1].triangle_count = 0xffffffff; }, "triangles and the scene 3"},
    {"SurfaceEmpty", [](Scene& s) { s.surfaces[0].triangle_count = 0; }, "surface 0"},
    {"SurfaceTwice", [](Scene& s) { s.surfaces[1].name = "floor"; }, "earlier surface"},
    {"SurfaceUnnamed", [](Scene& s) { s.surfaces[1].name = ""; }, "must have a name"},
    {"SurfaceControlCharacter", [](Scene& s) { s.surfaces[1].name = "a\x1b[2J"; }, "control characters"},
    {"SurfaceMaterial", [](Scene& s) { s.surfaces[1].material = 2; }, "material 2 of 2"},
    {"ReflectanceAboveOne", [](Scene& s) { s.spectra[0].samples[80] = 1.01f; }, "780 nm"},
    {"AlbedoSum", [](Scene& s) { s.spectra[0].samples[3] = 0.6f; }, "add up to 1.2"},
    {"NegativeSpectrum", [](Scene& s) { s.spectra[2].samples[3] = -1; }, "spectrum 2"},
    {"SlotSpectrum", [](Scene& s) { s.materials[0].mirror.spectrum = 3; }, "spectrum 3 of 3"},
    {"SlotTexture", [](Scene& s) { s.materials[0].diffuse.texture = 1; }, "texture 1 of 1"},
    {"DielectricShare", [](Scene& s) { s.materials[1].dielectric = 1.5f; }, "1.5"},
    {"DielectricNan", [](Scene& s) { s.materials[1].dielectric = nan; }, "dielectric share"},
    {"NoRefractiveIndex", [](Scene& s) { s.materials[1].refractive_index = none; }, "refractive index"},
    {"RefractiveIndexBelowOne", [](Scene& s) { s.spectra[1].samples[0] = 0.9f; }, "0.9 at 380 nm"},
    {"TextureSize", [](Scene& s) { s.textures[0].height = 2; }, "texture 0"},
    {"TextureEmpty", [](Scene& s) { s.textures[0] = {}; }, "0 x 0"},
    {"TextureNan", [](Scene& s) { s.textures[0].texels[1].c2 = nan; }, "not finite"},
    {"TextureWrap", [](Scene& s) { s.textures[0].wrap_u = static_cast<Wrap>(9); }, "wrap"},
    {"LightStrength", [](Scene& s) { s.lights[0].photometric = 0; }, "luminance or intensity 0"},
    {"LightStrengthNan", [](Scene& s) { s.lights[0].photometric = std::nan(""); }, "nan"},
    {"LightSpectrum", [](Scene& s) { s.lights[0].spectrum = none; }, "no spectrum"},
    {"LightDark", [](Scene& s) { s.spectra[2].samples.fill(0); }, "zero everywhere"},
    {"LightSurface", [](Scene& s) { s.lights[0].surface = 2; }, "surface 2 of 2"},
    {"LightTwice", [](Scene& s) { s.lights.push_back(s.lights[0]); }, "second light"},
    {"LightKind", [](Scene& s) { s.lights[0].kind = static_cast<LightKind>(3); }, "unknown kind"},
    {"LightDirection",
     [](Scene& s) {
         s.lights[2].direction = {0, -2, 0};
     },
     "length 1"},
    {"LightCone", [](Scene& s) { s.lights[2].cos_outer = 0.95; }, "cone"},
    {"LightFar", [](Scene& s) { s.lights[1].position.x = 1e300; }, "1e7"},
    {"CameraFov", [](Scene& s) { s.cameras[0].vertical_fov_degrees = 180; }, "180 degrees"},
    {"CameraAspect", [](Scene& s) { s.cameras[0].aspect = 0; }, "aspect"},
    {"CameraAxes",
     [](Scene& s) {
         s.cameras[0].up = {0, 0, 1};
     },
     "parallel"},
};

INSTANTIATE_TEST_SUITE_P(Validate, FaultyScene, testing::ValuesIn(faults),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(Geometry, AreaBoxAndSurfacesFollowThePositions) {
    const Scene scene = test::sample_scene();
    EXPECT_EQ(triangle_cross(scene, 0), (Vec3d{0, 0, 1}));
    EXPECT_EQ(triangle_area_m2(scene, 1), 0.5);
    EXPECT_EQ(bounding_box(scene).high, (Vec3d{1, 1, 1}));
    EXPECT_EQ(bounding_box(scene).low, (Vec3d{0, 0, 0}));
    EXPECT_TRUE(bounding_box(Scene{}).empty());
    EXPECT_EQ(surface_of_triangles(scene), (std::vector<std::uint32_t>{0, 0, 1}));
}

TEST(Text, NamesAreCleanedToUtf8WithoutControlCharacters) {
    EXPECT_TRUE(is_clean_name("Tür 7 \xe2\x82\xac"));
    EXPECT_FALSE(is_clean_name("a\nb"));
    EXPECT_FALSE(is_clean_name("\xc0\x80"));
    EXPECT_FALSE(is_clean_name("\xed\xa0\x80"));
    EXPECT_FALSE(is_clean_name("\xc2\x9b"));
    EXPECT_EQ(clean_name("a\x1b\xff b"), "a?? b");
    EXPECT_EQ(clean_name(std::string(5000, 'x')).size(), 1024u);
    EXPECT_TRUE(is_clean_name(clean_name(std::string(1023, 'x') + "\xe2\x82\xac")));
}

}  // namespace
}  // namespace lumenfarm
