#include "common/scene/scene_file.h"
#include "tests/import/files.h"

#include <cmath>

namespace lumenfarm {
namespace {

using test::warns_of;

const std::string triangle = "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";

ImportedScene import_obj(const std::string& obj, const std::string& mtl = "", const ImportOptions& options = {}) {
    const test::ImportFolder folder;
    folder.write("scene.mtl", mtl);
    folder.write("picture.png", test::tiny_png());
    auto result = import_scene(folder.write("scene.obj", obj), options);
    EXPECT_TRUE(result) << result.error().sentence;
    return result ? *result : ImportedScene{};
}

ImportedScene with_mtl(const std::string& statements, const ImportOptions& options = {}) {
    return import_obj(triangle, "newmtl m\n" + statements, options);
}

float sample(const ImportedScene& imported, const ColorSlot& slot) {
    return imported.scene.spectra.at(slot.spectrum).samples[40];
}

double area(const Scene& scene) {
    double sum = 0;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) sum += triangle_area_m2(scene, t);
    return sum;
}

TEST(Obj, ObjectsGroupsAndMaterialsMakeSurfaces) {
    const auto imported = import_obj(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\no chair\nusemtl wood\nf 1 2 3\nusemtl steel\nf 1 3 2\no table\nf -3 -2 -1\n");
    ASSERT_EQ(imported.scene.surfaces.size(), 3u);
    EXPECT_EQ(imported.scene.surfaces[0].name, "chair/wood");
    EXPECT_EQ(imported.scene.surfaces[1].name, "chair/steel");
    EXPECT_EQ(imported.scene.surfaces[1].object, "chair");
    EXPECT_EQ(imported.scene.surfaces[2].name, "table");
    EXPECT_TRUE(warns_of(imported, "unknown material 'wood'"));
}

TEST(Obj, ConcavePolygonsKeepTheirAreaAndFront) {
    // An L of area 3, seen from +z.
    const auto imported = import_obj("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 3 4 5 6 1 2\n");
    EXPECT_EQ(imported.scene.triangles.size(), 4u);
    EXPECT_DOUBLE_EQ(area(imported.scene), 3);
    for (std::uint32_t t = 0; t < 4; ++t) EXPECT_GT(triangle_cross(imported.scene, t).z, 0);
}

TEST(Obj, ContinuedLinesCommentsAndWindowsLineEndsAreRead) {
    const auto imported = import_obj("v 0 0 0\r\nv 1 0 0 # corner\r\nv 0 1 \\\n 0\nf 1 \\\r\n2 3 # face\n");
    EXPECT_EQ(area(imported.scene), 0.5);
}

TEST(Obj, ScaleMakesMetres) {
    EXPECT_NEAR(area(import_obj("v 0 0 0\nv 1000 0 0\nv 0 1000 0\nf 1 2 3\n", "", {false, 1, 0.001}).scene), 0.5, 1e-7);
}

TEST(Obj, MissingMaterialFileIsNamed) {
    const auto imported = import_obj("mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_TRUE(warns_of(imported, "'none.mtl' does not exist"));
}

TEST(Mtl, KdIsLambertAndKeIsLuminance) {
    const auto imported = with_mtl("Kd 0.5 0.5 0.5\nKe 2 2 2\n", {false, 100, 1});
    EXPECT_NEAR(sample(imported, imported.scene.materials[0].diffuse), 0.5, 1e-6);
    ASSERT_EQ(imported.scene.lights.size(), 1u);
    EXPECT_NEAR(imported.scene.lights[0].photometric, 200, 1e-3);
}

TEST(Mtl, HighlightsBecomeMirrorsOnlyWhenNarrow) {
    const auto narrow = with_mtl("Kd 0.5 0.5 0.5\nKs 0.25 0.25 0.25\nNs 900\nillum 2\n");
    EXPECT_NEAR(sample(narrow, narrow.scene.materials[0].mirror), 0.25, 1e-6);
    const auto broad = with_mtl("Kd 0.5 0.5 0.5\nKs 0.25 0.25 0.25\nNs 20\nillum 2\n");
    EXPECT_EQ(broad.scene.materials[0].mirror.spectrum, none);
    EXPECT_TRUE(warns_of(broad, "material 'm' has a broad highlight"));
}

TEST(Mtl, SumsAboveOneAreScaledWithAWarning) {
    const auto imported = with_mtl("Kd 0.8 0.8 0.8\nKs 0.8 0.8 0.8\nillum 3\n");
    EXPECT_NEAR(sample(imported, imported.scene.materials[0].diffuse), 0.5, 1e-6);
    EXPECT_NEAR(sample(imported, imported.scene.materials[0].mirror), 0.5, 1e-6);
    EXPECT_TRUE(warns_of(imported, "scaled down"));
}

TEST(Mtl, DissolveAndIlluminationModelMakeGlass) {
    const auto half = with_mtl("Kd 1 1 1\nd 0.25\nNi 1.5\nTf 0.5 0.5 0.5\n");
    const Material& m = half.scene.materials[0];
    EXPECT_EQ(m.dielectric, 0.75f);
    EXPECT_TRUE(m.thin);
    EXPECT_NEAR(sample(half, m.transmission), 0.5, 1e-6);
    EXPECT_EQ(half.scene.spectra[m.refractive_index], constant_spectrum(1.5));
    const auto whole = with_mtl("Kd 0 0 0\nillum 7\n");
    EXPECT_EQ(whole.scene.materials[0].dielectric, 1);
    EXPECT_TRUE(warns_of(whole, "1.5 is taken"));
}

TEST(Mtl, GlassOnAClosedMeshIsSolid) {
    const auto imported = import_obj(
        "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl m\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
        "newmtl m\nillum 7\nNi 1.5\n");
    EXPECT_FALSE(imported.scene.materials[0].thin);
    EXPECT_TRUE(warns_of(imported, "solid glass"));
}

TEST(Mtl, PictureIsTurnedSoThatItsFirstRowIsAtTheTop) {
    const auto imported =
        import_obj("mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n",
                   "newmtl m\nKd 1 1 1\nmap_Kd -clamp on picture.png\n");
    ASSERT_EQ(imported.scene.textures.size(), 1u);
    EXPECT_EQ(imported.scene.textures[0].wrap_u, Wrap::clamp);
    EXPECT_EQ(imported.scene.uvs[0], (Vec2f{0, 1}));
    EXPECT_EQ(imported.scene.uvs[2], (Vec2f{0, 0}));
}

TEST(DefaultLight, ShinesDownFromJustUnderTheTop) {
    const auto imported = import_obj("v 0 0 0\nv 4 0 0\nv 4 3 -4\nf 1 2 3\n", "", {true, 1, 1});
    ASSERT_EQ(imported.scene.lights.size(), 1u);
    const Surface& surface = imported.scene.surfaces.at(imported.scene.lights[0].surface);
    EXPECT_EQ(surface.name, "default light");
    EXPECT_LT(triangle_cross(imported.scene, surface.first_triangle).y, 0);
    const Scene& scene = imported.scene;
    const float y = scene.positions[scene.triangles[surface.first_triangle][0]].y;
    EXPECT_GT(y, 2.9f);
    EXPECT_LT(y, 3.0f);
    // 500 lx over the footprint of 4 m x 4 m.
    const double flux_lm =
        M_PI * imported.scene.lights[0].photometric * 2 * triangle_area_m2(scene, surface.first_triangle);
    EXPECT_NEAR(flux_lm, 500 * 16, 1e-3);
    EXPECT_FALSE(require_light(import_obj(triangle).scene));
}

TEST(DefaultLight, AFlatSceneIsLitFromAbove) {
    const auto imported = import_obj("v 0 1 0\nv 4 1 0\nv 4 1 -4\nf 1 2 3\n", "", {true, 1, 1});
    EXPECT_GT(bounding_box(imported.scene).high.y, 2);
}

TEST(OtherFormats, PlyAndStlAreReadThroughAssimp) {
    const test::ImportFolder folder;
    const auto ply = import_scene(
        folder.write("t.ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                     "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
                     "0\n0 1 0\n3 0 1 2\n"),
        {false, 1, 2});
    ASSERT_TRUE(ply) << ply.error().sentence;
    EXPECT_EQ(area(ply->scene), 2);
    EXPECT_GT(triangle_cross(ply->scene, 0).z, 0);
    const auto stl = import_scene(folder.write("t.stl",
                                               "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 "
                                               "0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n"),
                                  {});
    ASSERT_TRUE(stl) << stl.error().sentence;
    EXPECT_EQ(area(stl->scene), 0.5);
}

}  // namespace
}  // namespace lumenfarm
