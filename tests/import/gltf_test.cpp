#include "cli/import/optics.h"
#include "common/scene/scene_file.h"
#include "tests/import/files.h"

#include <cmath>

namespace lumenfarm {
namespace {

using test::import_square;
using test::square_gltf;
using test::warns_of;

const Material& only_material(const ImportedScene& imported) {
    EXPECT_EQ(imported.scene.materials.size(), 1u);
    return imported.scene.materials.at(0);
}

Spectrum spectrum_of(const ImportedScene& imported, std::uint32_t index) { return imported.scene.spectra.at(index); }

/// The square with this material instead of its own.
ImportedScene with_material(const std::string& members) {
    return import_square(R"("materials": [{)", R"("materials": [{"name": "tested", )" + members + "}, {");
}

double normal_z(const ImportedScene& imported) { return triangle_cross(imported.scene, 0).z; }

TEST(Gltf, SquareKeepsNameAreaAndFront) {
    const auto imported = import_square();
    ASSERT_EQ(imported.scene.surfaces.size(), 1u);
    EXPECT_EQ(imported.scene.surfaces[0].name, "square");
    EXPECT_EQ(imported.scene.triangles.size(), 2u);
    EXPECT_EQ(normal_z(imported), 1);
    EXPECT_TRUE(imported.warnings.empty()) << imported.warnings[0];
    EXPECT_FALSE(require_light(imported.scene));
}

TEST(Gltf, NodeTransformsMultiplyFromRootToLeaf) {
    const auto imported = import_square(
        R"("nodes": [{)",
        R"("nodes": [{"translation": [10, 0, 0], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476],
            "children": [1]}, {"scale": [2, 3, 1], "translation": [1, 0, 0], )");
    const Box box = bounding_box(imported.scene);
    EXPECT_NEAR(box.low.x, 7, 1e-6);  // a quarter turn: x becomes y, y becomes -x
    EXPECT_NEAR(box.high.x, 10, 1e-6);
    EXPECT_NEAR(box.low.y, 1, 1e-6);
    EXPECT_NEAR(box.high.y, 3, 1e-6);
    EXPECT_GT(normal_z(imported), 0);
}

TEST(Gltf, MatrixIsReadColumnByColumn) {
    const auto imported =
        import_square(R"("mesh": 0})", R"("mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1]})");
    EXPECT_EQ(bounding_box(imported.scene).low, (Vec3d{4, 5, 6}));
}

TEST(Gltf, MirroringScaleKeepsTheFrontOutside) {
    const auto mirrored = import_square(R"("mesh": 0})", R"("mesh": 0, "scale": [-1, 1, 1]})");
    EXPECT_EQ(bounding_box(mirrored.scene).low.x, -1);
    EXPECT_EQ(normal_z(mirrored), 1);
    const auto turned = import_square(R"("mesh": 0})", R"("mesh": 0, "scale": [1, 1, -1]})");
    EXPECT_EQ(normal_z(turned), -1);
}

TEST(Gltf, StripsAndFansBecomeTrianglesOfOneFront) {
    // Corners 0 1 3 2 as a strip and 0 1 2 3 as a fan are the same square.
    const auto strip = import_square(R"("indices": 1,)", R"("indices": 1, "mode": 5,)",
                                     test::square_bin({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 3, 2, 2, 2}));
    const auto fan = import_square(R"("indices": 1,)", R"("indices": 1, "mode": 6,)",
                                   test::square_bin({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 3, 3, 3}));
    for (const auto* imported : {&strip, &fan}) {
        EXPECT_TRUE(warns_of(*imported, "2 triangles without area"));
        double area = 0;
        ASSERT_EQ(imported->scene.triangles.size(), 2u);
        for (std::uint32_t t = 0; t < 2; ++t) {
            area += triangle_area_m2(imported->scene, t);
            EXPECT_GT(triangle_cross(imported->scene, t).z, 0);
        }
        EXPECT_EQ(area, 1);
    }
}

TEST(Gltf, PrimitivesWithoutIndicesUseTheVerticesInOrder) {
    const auto imported = import_square(R"("indices": 1,)", R"("mode": 6,)");
    EXPECT_EQ(imported.scene.triangles.size(), 2u);
    EXPECT_EQ(normal_z(imported), 1);
}

TEST(Gltf, SparseAccessorsReplaceElements) {
    // The second index, 1, is the element that takes the position of vertex 2: the first triangle collapses.
    const auto imported = import_square(R"("type": "VEC3")", R"("type": "VEC3", "sparse": {"count": 1, "indices":
        {"bufferView": 1, "byteOffset": 2, "componentType": 5123}, "values": {"bufferView": 0, "byteOffset": 24}})");
    EXPECT_TRUE(warns_of(imported, "1 triangles without area"));
    EXPECT_EQ(imported.scene.triangles.size(), 1u);
}

TEST(Gltf, PartsOfAnObjectHaveDifferentNames) {
    const auto imported = import_square(R"("primitives": [)",
                                        R"("primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0},
        {"attributes": {"POSITION": 0}, "indices": 1}, )");
    ASSERT_EQ(imported.scene.surfaces.size(), 3u);
    EXPECT_EQ(imported.scene.surfaces[0].name, "square/primitive 0");
    EXPECT_EQ(imported.scene.surfaces[1].name, "square/primitive 1");
    EXPECT_EQ(imported.scene.surfaces[2].name, "square/primitive 2");
    EXPECT_EQ(imported.scene.surfaces[2].object, "square");
    EXPECT_TRUE(warns_of(imported, "without a material"));
}

TEST(Gltf, EqualNamesAreToldApart) {
    const auto imported = import_square(R"("nodes": [0]}],
"nodes": [)",
                                        R"("nodes": [0, 1]}], "nodes": [{"name": "square", "mesh": 0}, )");
    ASSERT_EQ(imported.scene.surfaces.size(), 2u);
    EXPECT_EQ(imported.scene.surfaces[0].name, "square");
    EXPECT_EQ(imported.scene.surfaces[1].name, "square#2");
}

TEST(Gltf, GlbGivesTheSameBytesAsGltf) {
    const test::ImportFolder folder;
    const auto binary = import_scene(
        folder.write("square.glb",
                     test::glb(test::replaced(square_gltf, R"("uri": "mesh.bin", )", ""), test::square_bin())),
        {});
    ASSERT_TRUE(binary) << binary.error().sentence;
    EXPECT_EQ(encode_scene(binary->scene), encode_scene(import_square().scene));
}

TEST(GltfMaterial, GreyIsConstantOverWavelength) {
    const auto imported = import_square();
    const Material& m = only_material(imported);
    EXPECT_EQ(m.mirror.spectrum, none);
    for (const float s : spectrum_of(imported, m.diffuse.spectrum).samples) ASSERT_NEAR(s, 0.5f, 1e-7);
}

TEST(GltfMaterial, SmoothMetalIsAMirrorAndRoughMetalIsNamed) {
    const auto smooth = with_material(R"("pbrMetallicRoughness": {"roughnessFactor": 0.05})");
    EXPECT_EQ(only_material(smooth).diffuse.spectrum, none);
    EXPECT_EQ(spectrum_of(smooth, only_material(smooth).mirror.spectrum), constant_spectrum(1));
    const auto rough = with_material(R"("pbrMetallicRoughness": {"roughnessFactor": 0.4})");
    EXPECT_EQ(only_material(rough).mirror.spectrum, none);
    EXPECT_TRUE(warns_of(rough, "'tested') is a rough metal"));
}

TEST(GltfMaterial, SmoothNonMetalMixesFresnelAtNormalIncidence) {
    const auto imported = with_material(R"("pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0})");
    const Material& m = only_material(imported);
    EXPECT_NEAR(spectrum_of(imported, m.mirror.spectrum).samples[40], 0.04, 1e-6);
    EXPECT_NEAR(spectrum_of(imported, m.diffuse.spectrum).samples[40], 0.96, 1e-6);
    EXPECT_TRUE(warns_of(imported, "smooth non-metal"));
}

TEST(GltfMaterial, EmissionIsLuminanceTimesStrength) {
    const auto imported = with_material(R"("emissiveFactor": [1, 0.5, 0], "doubleSided": true,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 100}})");
    ASSERT_EQ(imported.scene.lights.size(), 1u);
    const Light& light = imported.scene.lights[0];
    EXPECT_NEAR(light.photometric, 100 * (0.2126 + 0.5 * 0.7152), 1e-9);
    EXPECT_EQ(light.kind, LightKind::surface);
    EXPECT_EQ(light.name, "square");
    EXPECT_EQ(light.surface, 0u);
    EXPECT_TRUE(only_material(imported).double_sided);
    EXPECT_TRUE(require_light(imported.scene));
}

TEST(GltfMaterial, EmissivePictureEmitsItsMean) {
    const auto imported = import_square(R"("materials": [{)",
                                        R"("images": [{"uri": "picture.png"}], "textures": [{"source": 0}],
        "materials": [{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}, {)");
    ASSERT_EQ(imported.scene.lights.size(), 1u);
    const double grey = std::pow((128 / 255.0 + 0.055) / 1.055, 2.4);
    const double mean = (0.2126 + 0.7152 + grey + 1) / 4;  // red, green, grey and white pixels
    EXPECT_NEAR(imported.scene.lights[0].photometric, mean, 1e-6);
    EXPECT_TRUE(warns_of(imported, "emissive picture"));
}

TEST(GltfMaterial, GlassIsThinOnASheetAndSolidWithAThickness) {
    const std::string glass = R"("pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions":
        {"KHR_materials_transmission": {"transmissionFactor": 0.75}, "KHR_materials_ior": {"ior": 1.6})";
    const auto sheet = with_material(glass + "}");
    EXPECT_EQ(only_material(sheet).dielectric, 0.75f);
    EXPECT_TRUE(only_material(sheet).thin);
    EXPECT_EQ(spectrum_of(sheet, only_material(sheet).refractive_index), constant_spectrum(1.6));
    const auto solid = with_material(glass + R"(, "KHR_materials_volume": {"thicknessFactor": 0.1}})");
    EXPECT_FALSE(only_material(solid).thin);
}

TEST(GltfMaterial, GlassOnAClosedMeshIsSolidWithAWarning) {
    // A tetrahedron that looks outwards, then with one face turned.
    const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::string from = R"("materials": [{)";
    const std::string to =
        R"("materials": [{"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}, {)";
    const auto of_indices = [&](std::vector<std::uint16_t> indices) {
        const test::ImportFolder folder;
        folder.write("mesh.bin", test::bytes_of(corners) + test::bytes_of(indices));
        std::string text = test::replaced(square_gltf, from, to);
        text = test::replaced(text, R"(, "TEXCOORD_0": 2)", "");
        text = test::replaced(text, R"("count": 6)", R"("count": 12)");
        text = test::replaced(text, R"("byteOffset": 48, "byteLength": 12)", R"("byteOffset": 48, "byteLength": 24)");
        text = test::replaced(text, R"("byteLength": 92)", R"("byteLength": 72)");
        auto imported = import_scene(folder.write("tetrahedron.gltf", text), {});
        EXPECT_TRUE(imported) << imported.error().sentence;
        return imported ? *imported : ImportedScene{};
    };
    const auto closed = of_indices({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
    EXPECT_FALSE(only_material(closed).thin);
    EXPECT_TRUE(warns_of(closed, "closed mesh"));
    const auto turned = of_indices({0, 2, 1, 0, 1, 3, 0, 2, 3, 1, 2, 3});
    EXPECT_TRUE(only_material(turned).thin);
}

TEST(GltfMaterial, DispersionFollowsTheAbbeNumber) {
    // BK7: n_d 1.5168, V 64.17, so dispersion 20 / 64.17.
    const auto imported = with_material(R"("extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_ior": {"ior": 1.5168}, "KHR_materials_dispersion": {"dispersion": 0.31167}})");
    const Spectrum n = spectrum_of(imported, only_material(imported).refractive_index);
    EXPECT_NEAR(value_at_nm(n, 587.56), 1.5168, 1e-4);
    EXPECT_NEAR((1.5168 - 1) / (value_at_nm(n, 486.13) - value_at_nm(n, 656.27)), 64.17, 0.1);
    EXPECT_NEAR(value_at_nm(n, 400), 1.530849, 1e-3);
}

TEST(GltfMaterial, PictureBecomesATextureOfReflectances) {
    const auto imported = import_square(R"("materials": [{)",
                                        R"("images": [{"uri": "picture.png"}],
        "samplers": [{"wrapS": 33071}], "textures": [{"source": 0, "sampler": 0}], "materials": [{"pbrMetallicRoughness":
        {"metallicFactor": 0, "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform":
        {"offset": [0.5, 0.25], "scale": [2, 1]}}}}}, {)");
    ASSERT_EQ(imported.scene.textures.size(), 1u);
    const Texture& texture = imported.scene.textures[0];
    EXPECT_EQ(texture.width, 2u);
    EXPECT_EQ(texture.wrap_u, Wrap::clamp);
    EXPECT_EQ(texture.wrap_v, Wrap::repeat);
    EXPECT_EQ(reflectance_at(texture.texels[3], 2000), 1);
    EXPECT_NEAR(reflectance_at(texture.texels[2], 100), std::pow((128 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
    EXPECT_GT(reflectance_at(texture.texels[0], 3000), reflectance_at(texture.texels[0], 1500));
    EXPECT_EQ(only_material(imported).diffuse.texture, 0u);
    ASSERT_EQ(imported.scene.uvs.size(), 4u);
    EXPECT_EQ(imported.scene.uvs[2], (Vec2f{2.5f, 1.25f}));
}

TEST(GltfMaterial, WhatIsLeftOutIsNamed) {
    const auto imported = with_material(R"("alphaMode": "BLEND", "pbrMetallicRoughness": {"metallicFactor": 0},
        "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}})");
    EXPECT_TRUE(warns_of(imported, "alpha mode BLEND"));
    EXPECT_TRUE(warns_of(imported, "KHR_materials_clearcoat"));
}

TEST(GltfSpectra, PointsAreInterpolatedAndTheirEndsContinue) {
    const auto imported = with_material(R"("pbrMetallicRoughness": {"metallicFactor": 0}, "extras":
        {"lumenfarm_spectra": {"diffuse": [[400, 0.2], [500, 0.4]], "emission": [[500, 1], [600, 3]],
        "luminance_cd_m2": 250}})");
    const Spectrum diffuse = spectrum_of(imported, only_material(imported).diffuse.spectrum);
    EXPECT_FLOAT_EQ(diffuse.samples[0], 0.2f);
    EXPECT_FLOAT_EQ(diffuse.samples[9], 0.25f);  // 425 nm
    EXPECT_FLOAT_EQ(diffuse.samples[80], 0.4f);
    ASSERT_EQ(imported.scene.lights.size(), 1u);
    EXPECT_EQ(imported.scene.lights[0].photometric, 250);
    EXPECT_FLOAT_EQ(spectrum_of(imported, imported.scene.lights[0].spectrum).samples[34], 2.0f);  // 550 nm
}

TEST(GltfSpectra, SellmeierGivesTheIndicesOfBk7) {
    const Spectrum n =
        import::sellmeier_index({1.03961212, 0.231792344, 1.01046945}, {0.00600069867, 0.0200179144, 103.560653});
    EXPECT_NEAR(n.samples[4], 1.530849, 1e-6);
    EXPECT_NEAR(n.samples[64], 1.513064, 1e-6);
}

/// The square with a node that carries this light, 3 m above it along z.
ImportedScene with_light(const std::string& members, const std::string& node = "") {
    return import_square(R"("nodes": [0]}],
"nodes": [)",
                         R"("nodes": [0, 1]}], "extensions": {"KHR_lights_punctual": {"lights": [{)" + members +
                             R"(}]}}, "nodes": [{"name": "lamp", "translation": [0, 0, 3], )" + node +
                             R"("extensions": {"KHR_lights_punctual": {"light": 0}}}, )");
}

TEST(GltfLight, PointIntensityIsCandelaTimesTheColoursLuminance) {
    const auto imported = with_light(R"("type": "point", "intensity": 800, "color": [1, 1, 0])");
    ASSERT_EQ(imported.scene.lights.size(), 1u);
    const Light& light = imported.scene.lights[0];
    EXPECT_EQ(light.kind, LightKind::point);
    EXPECT_EQ(light.name, "lamp");
    EXPECT_NEAR(light.photometric, 800 * (0.2126 + 0.7152), 1e-9);
    EXPECT_EQ(light.position, (Vec3d{0, 0, 3}));
    EXPECT_FALSE(light.lambertian);
}

TEST(GltfLight, SpotLooksAlongItsNodesMinusZ) {
    const auto imported = with_light(R"("type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2})",
                                     R"("rotation": [0, 0.7071067811865476, 0, 0.7071067811865476], )");
    ASSERT_EQ(imported.scene.lights.size(), 1u);
    const Light& light = imported.scene.lights[0];
    EXPECT_EQ(light.kind, LightKind::spot);
    EXPECT_NEAR(light.direction.x, -1, 1e-12);
    EXPECT_EQ(light.cos_inner, std::cos(0.1));
    EXPECT_EQ(light.cos_outer, std::cos(0.2));
}

TEST(GltfLight, OurExtensionMakesAPointLambertianWithASpectrum) {
    const auto imported = with_light(R"("type": "point", "intensity": 1000, "extras": {"lumenfarm_spectra":
        {"distribution": "lambertian", "emission": [[380, 1], [780, 1]]}})");
    ASSERT_EQ(imported.scene.lights.size(), 1u);
    EXPECT_TRUE(imported.scene.lights[0].lambertian);
    EXPECT_EQ(imported.scene.lights[0].direction, (Vec3d{0, 0, -1}));
    EXPECT_EQ(spectrum_of(imported, imported.scene.lights[0].spectrum), constant_spectrum(1));
}

TEST(GltfLight, DirectionalIsLeftOutByName) {
    const auto imported = with_light(R"("name": "sun", "type": "directional", "intensity": 5)");
    EXPECT_TRUE(imported.scene.lights.empty());
    EXPECT_TRUE(warns_of(imported, "'sun'"));
}

TEST(GltfCamera, LooksAlongMinusZWithItsFieldOfView) {
    const auto imported = import_square(R"("nodes": [0]}],
"nodes": [)",
                                        R"("nodes": [0, 1]}], "cameras": [{"type": "perspective", "perspective":
        {"yfov": 0.5, "aspectRatio": 2, "znear": 0.1}}],
        "nodes": [{"name": "view", "camera": 0, "translation": [0, 1, 5]}, )");
    ASSERT_EQ(imported.scene.cameras.size(), 1u);
    const Camera& camera = imported.scene.cameras[0];
    EXPECT_EQ(camera.name, "view");
    EXPECT_EQ(camera.position, (Vec3d{0, 1, 5}));
    EXPECT_EQ(camera.forward, (Vec3d{0, 0, -1}));
    EXPECT_EQ(camera.up, (Vec3d{0, 1, 0}));
    EXPECT_NEAR(camera.vertical_fov_degrees, 28.6479, 1e-4);
    EXPECT_EQ(camera.aspect, 2);
}

}  // namespace
}  // namespace lumenfarm
