#include "tests/import/files.h"

#include <sys/stat.h>

#include <limits>

namespace lumenfarm {
namespace {

using test::glb;
using test::ImportFolder;
using test::replaced;
using test::square_bin;
using test::square_gltf;

/// What is refused: the files are written, `file` is imported, the sentence must have `says`.
struct Case {
    std::string name;
    std::string file;
    std::string text;
    std::string says;
    std::string bin = square_bin();
};

void PrintTo(const Case& bad, std::ostream* out) { *out << bad.name; }

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

/// The square with a change to its text.
Case gltf(const std::string& name, const std::string& from, const std::string& to, const std::string& says) {
    return {name, "scene.gltf", replaced(square_gltf, from, to), says};
}

Case gltf_positions(const std::string& name, std::vector<float> positions, const std::string& says) {
    return {name, "scene.gltf", square_gltf, says, square_bin(std::move(positions))};
}

Case obj(const std::string& name, const std::string& text, const std::string& says) {
    return {name, "scene.obj", text, says};
}

/// A triangle with the material "m" of an MTL that has `statements`.
Case mtl(const std::string& name, const std::string& statements, const std::string& says) {
    return {name, "scene.obj", "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n", says,
            "newmtl m\n" + statements};
}

std::string material(const std::string& members) { return R"("materials": [{"name": "glow", )" + members + "}, {"; }

std::string light(const std::string& members) {
    return R"("extensions": {"KHR_lights_punctual": {"lights": [{)" + members + R"(}]}}, "nodes": [{"extensions":
        {"KHR_lights_punctual": {"light": 0}}, )";
}

std::vector<Case> cases() {
    const std::string square_glb = glb(replaced(square_gltf, R"("uri": "mesh.bin", )", ""), square_bin());
    std::string long_chunk = square_glb;
    long_chunk[12] = '\xff';
    long_chunk[13] = '\xff';
    std::string deep(100'000, '[');
    return {
        {"GltfEmpty", "scene.gltf", "", "empty"},
        {"GlbEmpty", "scene.glb", "", "empty"},
        {"ObjEmpty", "scene.obj", "", "empty"},
        {"PlyEmpty", "scene.ply", "", "empty"},
        {"ExtensionUnknown", "scene.txt", "hello", "'.txt'"},
        {"ExtensionMissing", "scene", "hello", "extension ''"},
        {"GlbTruncated", "scene.glb", square_glb.substr(0, square_glb.size() - 20), "truncated"},
        {"GlbHeaderOnly", "scene.glb", square_glb.substr(0, 12), "truncated"},
        {"GlbChunkTooLong", "scene.glb", long_chunk, "truncated"},
        {"GlbVersion1", "scene.glb", replaced(square_glb, std::string("\2\0\0\0", 4), std::string("\1\0\0\0", 4)),
         "version 1"},
        {"GlbIsText", "scene.glb", square_gltf, "not a GLB"},
        {"GlbNestsDeeply", "scene.glb", glb(deep, "0000"), "nests deeper"},
        {"GltfNestsDeeply", "scene.gltf", deep, "nests deeper"},
        {"GltfNestsDeeplyInExtras", "scene.gltf", "{\"extras\":" + std::string(70, '{'), "nests deeper"},
        {"GltfIsNoJson", "scene.gltf", "this is not JSON", "not a valid glTF"},
        {"GltfIsArray", "scene.gltf", "[1, 2, 3]", "not a valid glTF"},
        {"GltfNumberOverflow", "scene.gltf", replaced(square_gltf, "\"scene\": 0", "\"scene\": 1e999"), "glTF"},
        {"GltfBinaryNoise", "scene.gltf", std::string(300, '\x80'), "not a valid glTF"},
        gltf("GltfVersion1", "\"2.0\"", "\"1.0\"", "version '1.0'"),
        gltf("GltfExtensionRequired", "\"scene\": 0", R"("scene": 0, "extensionsRequired": ["EXT_magic"])",
             "'EXT_magic'"),
        gltf("GltfSceneMissing", "\"scene\": 0", "\"scene\": 7", "default scene is 7"),
        gltf("GltfNodeMissing", "\"nodes\": [0]", "\"nodes\": [5]", "node 5"),
        gltf("GltfNodeNegative", "\"nodes\": [0]", "\"nodes\": [-2]", "node -2"),
        gltf("GltfNodesCycle", "\"mesh\": 0}", "\"mesh\": 0, \"children\": [0]}", "cycle"),
        gltf("GltfMeshMissing", "\"mesh\": 0", "\"mesh\": 3", "mesh 3"),
        gltf("GltfAccessorMissing", "\"POSITION\": 0", "\"POSITION\": 9", "accessor 9"),
        gltf("GltfAccessorNegative", "\"POSITION\": 0", "\"POSITION\": -4", "accessor -4"),
        gltf("GltfPositionMissing", "\"POSITION\"", "\"NORMAL\"", "no POSITION"),
        gltf("GltfIndicesMissing", "\"indices\": 1", "\"indices\": 12", "out of bounds"),
        gltf("GltfMaterialMissing", "\"material\": 0", "\"material\": 6", "material 6"),
        gltf("GltfCountBeyondBuffer", "\"count\": 4", "\"count\": 5", "5 elements"),
        gltf("GltfCountHuge", "\"count\": 4", "\"count\": 4000000000000", "4000000000000"),
        gltf("GltfCountNegative", "\"count\": 4", "\"count\": -4", "count"),
        gltf("GltfCountZero", "\"count\": 4", "\"count\": 0", "count 0"),
        gltf("GltfOffsetBeyondView", "\"bufferView\": 0,", "\"bufferView\": 0, \"byteOffset\": 1000,", "byte 1000"),
        gltf("GltfComponentType", "\"componentType\": 5126", "\"componentType\": 5127", "component type 5127"),
        gltf("GltfVectorsOfTwo", "\"VEC3\"", "\"VEC2\"", "3 components"),
        gltf("GltfIndicesAsFloats", "\"componentType\": 5123, \"count\": 6", "\"componentType\": 5126, \"count\": 3",
             "unsigned integers"),
        gltf("GltfViewMissing", "\"bufferView\": 0", "\"bufferView\": 8", "buffer view 8"),
        gltf("GltfViewBeyondBuffer", "\"byteOffset\": 48", "\"byteOffset\": 4800", "4800"),
        gltf("GltfViewOffsetOverflows", "\"byteOffset\": 48", "\"byteOffset\": 18446744073709551612", "buffer"),
        gltf("GltfBufferMissing", "\"buffer\": 0", "\"buffer\": 3", "buffer 3"),
        gltf("GltfSparseOutOfRange", "\"type\": \"VEC3\"",
             R"("type": "VEC3", "sparse": {"count": 1, "indices": {"bufferView": 0, "byteOffset": 12,
                "componentType": 5126}, "values": {"bufferView": 0, "byteOffset": 40}})",
             "accessor 0"),
        gltf("GltfSparseIndex", "\"type\": \"VEC3\"",
             R"("type": "VEC3", "sparse": {"count": 1, "indices": {"bufferView": 0, "byteOffset": 15,
                "componentType": 5121}, "values": {"bufferView": 0}})",
             "sparse index"),
        gltf("GltfBinMissing", "mesh.bin", "none.bin", "none.bin"),
        gltf("GltfBinOutside", "mesh.bin", "../mesh.bin", "leads out"),
        gltf("GltfBinOutsideEncoded", "mesh.bin", "%2e%2e/mesh.bin", "leads out"),
        gltf("GltfBinAbsolute", "mesh.bin", "/etc/passwd", "absolute"),
        gltf("GltfBinAddress", "mesh.bin", "http://localhost/mesh.bin", "address"),
        gltf("GltfBinShort", "\"byteLength\": 92", "\"byteLength\": 900", "size mismatch"),
        gltf("GltfMatrixSize", "\"mesh\": 0}", "\"mesh\": 0, \"matrix\": [1, 2]}", "node 0"),
        gltf("GltfRotationNone", "\"mesh\": 0}", "\"mesh\": 0, \"rotation\": [0, 0, 0, 0]}", "rotation"),
        gltf("GltfPositionsLeaveWorld", "\"mesh\": 0}", "\"mesh\": 0, \"translation\": [1e20, 0, 0]}", "1e7"),
        gltf("GltfScaledToNothing", "\"mesh\": 0}", "\"mesh\": 0, \"scale\": [0, 0, 0]}", "no triangle"),
        gltf("GltfPointsOnly", "\"material\": 0", "\"material\": 0, \"mode\": 0", "no triangle"),
        gltf("GltfColourAboveOne", "[0.5, 0.5, 0.5, 1]", "[0.5, 1.5, 0.5, 1]", "baseColorFactor"),
        gltf("GltfColourOfTwo", "[0.5, 0.5, 0.5, 1]", "[0.5, 1]", "baseColorFactor"),
        gltf("GltfMetallicAboveOne", "\"metallicFactor\": 0", "\"metallicFactor\": 2", "metallicFactor"),
        gltf("GltfIorBelowOne", "\"materials\": [{", material(R"("extensions": {"KHR_materials_ior": {"ior": 0.5}})"),
             "ior is 0.5"),
        gltf("GltfEmissiveNegative", "\"materials\": [{", material(R"("emissiveFactor": [1, -1, 0])"),
             "emissiveFactor"),
        gltf("GltfSpectrumFalls", "\"materials\": [{",
             material(R"("extras": {"lumenfarm_spectra": {"diffuse": [[500, 0.1], [400, 0.2]]}})"), "increase"),
        gltf("GltfSpectrumAboveOne", "\"materials\": [{",
             material(R"("extras": {"lumenfarm_spectra": {"diffuse": [[500, 1.1]]}})"), "1.1"),
        gltf("GltfSpectrumShape", "\"materials\": [{",
             material(R"("extras": {"lumenfarm_spectra": {"diffuse": [[500]]}})"), "place 0"),
        gltf("GltfSpectrumUnknown", "\"materials\": [{",
             material(R"("extras": {"lumenfarm_spectra": {"difuse": [[500, 1]]}})"), "difuse"),
        gltf("GltfEmissionWithoutLuminance", "\"materials\": [{",
             material(R"("extras": {"lumenfarm_spectra": {"emission": [[500, 1]]}})"), "luminance"),
        gltf("GltfSellmeierPole", "\"materials\": [{",
             material(R"("extras": {"lumenfarm_spectra": {"refractive_index": {"sellmeier":
                {"B": [1, 0, 0], "C": [0.25, 0, 0]}}}})"),
             "sellmeier"),
        gltf("GltfPictureMissing", "\"materials\": [{",
             R"("images": [{"uri": "none.png"}], "textures": [{"source": 0}], )" +
                 material(R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0}})"),
             "none.png"),
        gltf("GltfPictureOutside", "\"materials\": [{",
             R"("images": [{"uri": "../picture.png"}], "textures": [{"source": 0}], )" +
                 material(R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0}})"),
             "leads out"),
        gltf("GltfPictureDamaged", "\"materials\": [{",
             R"("images": [{"uri": "mesh.bin"}], "textures": [{"source": 0}], )" +
                 material(R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0}})"),
             "neither PNG nor JPEG"),
        gltf("GltfPictureViewBeyondBuffer", "\"materials\": [{",
             R"("images": [{"bufferView": 70, "mimeType": "image/png"}], "textures": [{"source": 0}], )" +
                 material(R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0}})"),
             "70"),
        gltf("GltfTextureMissing", "\"materials\": [{",
             material(R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 4}})"), "texture 4"),
        gltf("GltfLightMissing", "\"nodes\": [{", R"("nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}, )",
             "light 0"),
        gltf("GltfLightNegative", "\"nodes\": [{", light(R"("type": "point", "intensity": -5)"), "-5"),
        gltf("GltfLightCone", "\"nodes\": [{",
             light(R"("type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.4})"), "cone angles"),
        gltf("GltfLightFlattened", "\"nodes\": [{", light(R"("type": "spot", "spot": {})") + R"("scale": [1, 1, 0], )",
             "no direction"),
        gltf("GltfCameraMissing", "\"mesh\": 0}", "\"camera\": 0}", "camera 0"),
        gltf(
            "GltfCameraFov", "\"nodes\": [{",
            R"("cameras": [{"type": "perspective", "perspective": {"yfov": 4, "znear": 1}}], "nodes": [{"camera": 0, )",
            "field of view"),
        gltf_positions("GltfNan", {0, 0, 0, 1, nan, 0, 1, 1, 0, 0, 1, 0}, "finite"),
        gltf_positions("GltfInfinity", {0, 0, 0, 1, 0, 0, 1, infinity, 0, 0, 1, 0}, "finite"),
        gltf_positions("GltfZeroArea", std::vector<float>(12, 0.5f), "no triangle with an area"),
        {"GltfIndexOutOfRange", "scene.gltf", square_gltf, "index 4",
         square_bin({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 4})},
        obj("ObjNoFaces", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangle"),
        obj("ObjZeroArea", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no triangle"),
        obj("ObjNan", "v 0 0 0\nv nan 0 0\n", "line 2"),
        obj("ObjInfinity", "v 0 0 inf\n", "'inf'"),
        obj("ObjOverflow", "v 0 0 1e999\n", "1e999"),
        obj("ObjWord", "v 0 0 zero\n", "'zero'"),
        obj("ObjTwoCoordinates", "v 0 0\n", "3 numbers"),
        obj("ObjIndexOutOfRange", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "vertex 4"),
        obj("ObjIndexBefore", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 -2 -1\n", "vertex -4"),
        obj("ObjIndexZero", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "'0'"),
        obj("ObjIndexHuge", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999\n", "99999999999"),
        obj("ObjUvOutOfRange", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n", "texture coordinate 1"),
        obj("ObjTwoCorners", "v 0 0 0\nv 1 0 0\nf 1 2\n", "2 corners"),
        obj("ObjFar", "v 0 0 0\nv 1e8 0 0\nv 0 1 0\nf 1 2 3\n", "1e7"),
        obj("ObjZeroByte", std::string("v 0 0 0\0\n", 9), "zero byte"),
        obj("ObjMtlOutside", "mtllib ../scene.mtl\nv 0 0 0\n", "leads out"),
        obj("ObjMtlAbsolute", "mtllib /etc/passwd\nv 0 0 0\n", "absolute"),
        mtl("MtlNan", "Kd nan 0 0\n", "'nan'"),
        mtl("MtlTwoNumbers", "Kd 1 0\n", "3 numbers"),
        mtl("MtlSpectral", "Kd spectral file.rfl 1\n", "'spectral'"),
        mtl("MtlNegative", "Kd -1 0 0\n", "negative Kd"),
        mtl("MtlDissolve", "d 1.5\n", "1.5"),
        mtl("MtlPictureMissing", "Kd 1 1 1\nmap_Kd none.png\n", "none.png"),
        mtl("MtlPictureOutside", "Kd 1 1 1\nmap_Kd ../picture.png\n", "leads out"),
        mtl("MtlPictureDamaged", "Kd 1 1 1\nmap_Kd scene.mtl\n", "scene.mtl"),
        mtl("MtlEmissionHuge", "Ke 1e30 1e30 1e30\n", "emits"),
        {"PlyNoise", "scene.ply", "ply\nformat ascii 1.0\nelement vertex 99\nend_header\n1 2", "scene.ply"},
        {"StlTruncated", "scene.stl", std::string(84, '\x01'), "scene.stl"},
        {"DaeNoise", "scene.dae", "<COLLADA", "scene.dae"},
    };
}

class BadInput : public testing::TestWithParam<Case> {};

TEST_P(BadInput, IsRefusedInOneSentence) {
    const Case& bad = GetParam();
    const ImportFolder folder;
    folder.write("mesh.bin", bad.bin);
    folder.write("scene.mtl", bad.bin);
    const auto path = folder.write(bad.file, bad.text);
    const auto result = import_scene(path, {});
    ASSERT_FALSE(result);
    const std::string& sentence = result.error().sentence;
    EXPECT_EQ(result.error().code, ErrorCode::bad_input);
    EXPECT_NE(sentence.find(bad.says), std::string::npos) << sentence;
    EXPECT_NE(sentence.find("scene"), std::string::npos) << "names no file: " << sentence;
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
    EXPECT_LT(sentence.size(), 1'200u);
}

INSTANTIATE_TEST_SUITE_P(Import, BadInput, testing::ValuesIn(cases()),
                         [](const auto& instance) { return instance.param.name; });

TEST(BadInputPlace, MissingFilesFoldersAndPipesAreRefused) {
    const ImportFolder folder;
    std::filesystem::create_directory(folder / "folder.obj");
    ASSERT_EQ(mkfifo((folder / "pipe.gltf").c_str(), 0600), 0);
    for (const char* name : {"none.gltf", "folder.obj", "pipe.gltf", "none/none.obj"}) {
        const auto result = import_scene(folder / name, {});
        ASSERT_FALSE(result) << name;
        EXPECT_EQ(result.error().code, ErrorCode::bad_input);
        EXPECT_NE(result.error().sentence.find(name), std::string::npos) << result.error().sentence;
    }
}

TEST(BadInputPlace, OptionsOutOfRangeAreRefused) {
    const ImportFolder folder;
    const auto path = folder.write("scene.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (const double factor : {0.0, -1.0, 1e300, double{nan}, double{infinity}}) {
        EXPECT_FALSE(import_scene(path, {false, 1, factor})) << factor;
        EXPECT_FALSE(import_scene(path, {false, factor, 1})) << factor;
    }
    EXPECT_TRUE(import_scene(path, {false, 1, 0.001}));
}

}  // namespace
}  // namespace lumenfarm
