#include "cli/import/image.h"
#include "cli/import/mesh.h"
#include "cli/import/optics.h"
#include "cli/import/readers.h"
#include "cli/import/resource.h"
#include "cli/import/transform.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <numbers>

namespace lumenfarm::import {
namespace {

constexpr unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_ValidateDataStructure;

Vec3d vec(const aiVector3D& v) { return {double{v.x}, double{v.y}, double{v.z}}; }
Vec3d rgb(const aiColor3D& c) { return {double{c.r}, double{c.g}, double{c.b}}; }
bool finite_colour(Vec3d c) { return std::isfinite(dot(c, c)) && c.x >= 0 && c.y >= 0 && c.z >= 0; }

Transform transform(const aiMatrix4x4& m) {
    return {{Vec3d{double{m.a1}, double{m.b1}, double{m.c1}}, Vec3d{double{m.a2}, double{m.b2}, double{m.c2}},
             Vec3d{double{m.a3}, double{m.b3}, double{m.c3}}, Vec3d{double{m.a4}, double{m.b4}, double{m.c4}}}};
}

/// Walks Assimp's scene; lengths are scaled to metres at the root.
class AssimpWalk {
public:
    AssimpWalk(const aiScene& scene, SceneBuilder& builder) : scene_(scene), builder_(builder) {}

    Result<void> visit(const aiNode& node, const Transform& parent, std::size_t depth) {
        const std::string name = node.mName.C_Str();
        if (depth > limits::node_depth_max)
            return builder_.refuse("node '" + name + "' lies deeper than " + std::to_string(limits::node_depth_max) +
                                   " levels");
        const Transform to_world = parent.after(transform(node.mTransformation));
        for (unsigned i = 0; i < node.mNumMeshes; ++i)
            if (auto r = add_mesh(*scene_.mMeshes[node.mMeshes[i]], name, node.mNumMeshes > 1, to_world); !r) return r;
        for (unsigned i = 0; i < scene_.mNumLights; ++i)
            if (scene_.mLights[i]->mName == node.mName) add_light(*scene_.mLights[i], name, to_world);
        for (unsigned i = 0; i < scene_.mNumCameras; ++i)
            if (scene_.mCameras[i]->mName == node.mName) add_camera(*scene_.mCameras[i], name, to_world);
        for (unsigned i = 0; i < node.mNumChildren; ++i)
            if (auto r = visit(*node.mChildren[i], to_world, depth + 1); !r) return r;
        return {};
    }

private:
    Result<void> add_mesh(const aiMesh& mesh, const std::string& node, bool several, const Transform& to_world) {
        if ((mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) {
            builder_.warn("object '" + node + "' has points or lines, which are left out");
            return {};
        }
        MeshPart part;
        const std::string own = mesh.mName.C_Str();
        part.object = !node.empty() ? node : !own.empty() ? own : builder_.file().stem().string();
        const auto material = compile(mesh.mMaterialIndex);
        if (!material) return material.error();
        part.material = *material;
        if (several) part.part = builder_.scene().materials[material->index].name;
        for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
            part.positions.push_back(to_world.point(vec(mesh.mVertices[i])));
            const bool has_uv = mesh.HasTextureCoords(0);
            part.uvs.push_back(has_uv ? Vec2f{mesh.mTextureCoords[0][i].x, 1 - mesh.mTextureCoords[0][i].y} : Vec2f{});
        }
        for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
            const aiFace& face = mesh.mFaces[i];
            if (face.mNumIndices != 3) continue;
            part.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
            if (to_world.mirrors()) std::swap(part.triangles.back()[1], part.triangles.back()[2]);
        }
        return builder_.add_mesh(std::move(part));
    }

    Result<ImportedMaterial> compile(unsigned index) {
        if (const auto known = compiled_.find(index); known != compiled_.end()) return known->second;
        const aiMaterial& given = *scene_.mMaterials[index];
        const std::string name = given.GetName().C_Str();
        const std::string who = "material " + std::to_string(index) + " ('" + name + "')";
        aiColor3D diffuse(0.8f, 0.8f, 0.8f), emissive(0, 0, 0);
        if (given.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) != AI_SUCCESS)
            builder_.warn(who + " has no diffuse colour; reflectance 0.8 is taken");
        given.Get(AI_MATKEY_COLOR_EMISSIVE, emissive);
        if (!finite_colour(rgb(diffuse)) || !finite_colour(rgb(emissive)))
            return builder_.refuse(who + " has a colour that is negative or not finite");
        Material out;
        out.name = name.empty() ? who : name;
        out.diffuse.spectrum = builder_.add_reflectance(rgb(diffuse));
        if (auto picture = set_picture(given, out, who); !picture) return picture.error();
        warn_of_rest(given, who);
        ImportedMaterial made;
        made.luminance = std::min(luminance_of(rgb(emissive)), limits::photometric_max);
        if (made.luminance > 0) made.emission_spectrum = builder_.add_light_spectrum(rgb(emissive));
        made.index = builder_.add_material(std::move(out));
        return compiled_[index] = made;
    }

    Result<void> set_picture(const aiMaterial& given, Material& out, const std::string& who) {
        aiString file;
        if (given.GetTexture(aiTextureType_DIFFUSE, 0, &file) != AI_SUCCESS) return {};
        const std::string name = file.C_Str();
        if (scene_.GetEmbeddedTexture(file.C_Str()) != nullptr) {
            builder_.warn(who + " has a picture inside the file, which is left out");
            return {};
        }
        const auto path = resource_path(builder_.file(), name);
        if (!path) return path.error();
        const auto picture = read_picture(*path, name);
        if (!picture) return builder_.refuse(who + ": " + picture.error().sentence);
        out.diffuse.texture = builder_.add_texture(to_texture(*picture));
        return {};
    }

    void warn_of_rest(const aiMaterial& given, const std::string& who) {
        aiColor3D specular(0, 0, 0);
        float opacity = 1;
        given.Get(AI_MATKEY_COLOR_SPECULAR, specular);
        given.Get(AI_MATKEY_OPACITY, opacity);
        if (luminance_of(rgb(specular)) > 0) builder_.warn(who + " has a highlight, which is left out");
        if (opacity < 1) builder_.warn(who + " is transparent; it is taken as opaque");
    }

    void add_light(const aiLight& given, const std::string& name, const Transform& to_world) {
        const Vec3d colour = rgb(given.mColorDiffuse);
        const double intensity = finite_colour(colour) ? luminance_of(colour) : 0;
        const Vec3d direction = to_world.vector(vec(given.mDirection));
        const bool spot = given.mType == aiLightSource_SPOT;
        if ((given.mType != aiLightSource_POINT && !spot) || !(intensity > 0) || (spot && !(length(direction) > 0))) {
            builder_.warn("light '" + name + "' is neither a point nor a spot light with an intensity; it is left out");
            return;
        }
        Light light;
        light.name = name;
        light.kind = spot ? LightKind::spot : LightKind::point;
        light.photometric = std::min(intensity, limits::photometric_max);
        light.spectrum = builder_.add_light_spectrum(colour);
        light.position = to_world.point(vec(given.mPosition));
        if (spot) {
            light.direction = normalize(direction);
            const double outer = std::clamp(double{given.mAngleOuterCone} / 2, 0.001, std::numbers::pi / 2);
            light.cos_outer = std::cos(outer);
            light.cos_inner = std::cos(std::clamp(double{given.mAngleInnerCone} / 2, 0.0, outer));
        }
        builder_.add_light(std::move(light));
    }

    void add_camera(const aiCamera& given, const std::string& name, const Transform& to_world) {
        const Vec3d forward = to_world.vector(vec(given.mLookAt));
        const Vec3d up = to_world.vector(vec(given.mUp));
        if (!(length(cross(forward, up)) > 0) || !std::isfinite(dot(forward, up))) {
            builder_.warn("camera '" + name + "' has no direction and is left out");
            return;
        }
        Camera camera;
        camera.name = name;
        camera.position = to_world.point(vec(given.mPosition));
        camera.forward = normalize(forward);
        camera.up = normalize(up - camera.forward * dot(camera.forward, up));
        camera.aspect = given.mAspect > 0 ? double{given.mAspect} : 1;
        // Assimp gives half the horizontal angle in some formats and all of it in others; the documentation says half.
        const double half = std::clamp(double{given.mHorizontalFOV} / 2, 0.01, 1.5);
        camera.vertical_fov_degrees = 2 * std::atan(std::tan(half) / camera.aspect) * 180 / std::numbers::pi;
        builder_.add_camera(std::move(camera));
    }

    const aiScene& scene_;
    SceneBuilder& builder_;
    std::map<unsigned, ImportedMaterial> compiled_;
};

}  // namespace

bool assimp_reads(const std::string& extension) {
    const Assimp::Importer importer;
    return !extension.empty() && importer.IsExtensionSupported(extension);
}

Result<void> read_by_assimp(SceneBuilder& builder, const ImportOptions& options) {
    const auto bytes = read_file(builder.file(), limits::import_file_bytes_max);
    if (!bytes) return bytes.error();
    if (bytes->empty()) return builder.refuse("the file is empty");
    try {
        Assimp::Importer importer;
        // Lines and points are sorted away into meshes of their own, which the walk leaves out by name.
        const aiScene* scene = importer.ReadFile(builder.file().string(), steps);
        if (scene == nullptr || scene->mRootNode == nullptr)
            return builder.refuse(std::string("the file cannot be read: ") + importer.GetErrorString());
        if ((scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0 && scene->mNumMeshes == 0)
            return builder.refuse("the file has no triangles");
        Transform to_metres;
        for (std::size_t c = 0; c < 3; ++c) to_metres.columns[c] = to_metres.columns[c] * options.scale;
        return AssimpWalk(*scene, builder).visit(*scene->mRootNode, to_metres, 0);
    } catch (const std::exception& error) {
        return builder.refuse(std::string("the file cannot be read: ") + error.what());
    }
}

}  // namespace lumenfarm::import
