#include "cli/import/mesh.h"
#include "cli/import/mtl_material.h"
#include "cli/import/obj_text.h"
#include "cli/import/readers.h"
#include "cli/import/resource.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <algorithm>
#include <exception>
#include <map>
#include <sstream>
#include <tuple>

namespace lumenfarm::import {
namespace {

struct Corner {
    std::uint32_t position = 0, uv = none;
    auto operator<=>(const Corner&) const = default;
};

/// Faces of one object, group and material, in the order of the file.
struct FaceGroup {
    std::string object, group, material;
    std::vector<Corner> corners;
    std::vector<std::uint32_t> corners_of_face;
};

std::string_view text_of(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string trimmed(const std::string& text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// What the library calls back: gathers positions, texture coordinates and faces. Indices are resolved and checked
/// here.
class ObjContent {
public:
    explicit ObjContent(double scale) : scale_(scale) {}

    static tinyobj::callback_t callbacks() {
        tinyobj::callback_t c;
        c.vertex_cb = [](void* self, double x, double y, double z, double) {
            auto& content = *static_cast<ObjContent*>(self);
            content.positions.push_back(Vec3d{x, y, z} * content.scale_);
        };
        c.texcoord_cb = [](void* self, double u, double v, double) {
            // A picture's first row is at v = 1 in OBJ and at v = 0 in a compiled scene.
            static_cast<ObjContent*>(self)->uvs.push_back({static_cast<float>(u), static_cast<float>(1 - v)});
        };
        c.index_cb = [](void* self, tinyobj::index_t* corners, int count) {
            static_cast<ObjContent*>(self)->add_face({corners, static_cast<std::size_t>(count)});
        };
        c.usemtl_cb = [](void* self, const char* name, int) {
            static_cast<ObjContent*>(self)->material_ = trimmed(name);
        };
        c.object_cb = [](void* self, const char* name) { static_cast<ObjContent*>(self)->object_ = trimmed(name); };
        c.group_cb = [](void* self, const char** names, int count) {
            std::string& group = static_cast<ObjContent*>(self)->group_;
            group.clear();
            for (int i = 0; i < count; ++i) group += (i > 0 ? " " : "") + std::string(names[i]);
        };
        return c;
    }

    std::vector<Vec3d> positions;
    std::vector<Vec2f> uvs;
    std::vector<FaceGroup> groups;
    std::string fault;  ///< the first face with an index out of range

private:
    /// From 1 on, or backwards from -1. Nothing out of range.
    static std::uint32_t resolve(int index, std::size_t count) {
        const std::int64_t place = index > 0 ? index - 1 : static_cast<std::int64_t>(count) + index;
        return place >= 0 && place < static_cast<std::int64_t>(count) ? static_cast<std::uint32_t>(place) : none;
    }

    FaceGroup& current() {
        const auto [place, is_new] = index_.try_emplace(std::tuple(object_, group_, material_), groups.size());
        if (is_new) groups.push_back({object_, group_, material_, {}, {}});
        return groups[place->second];
    }

    void add_face(std::span<const tinyobj::index_t> corners) {
        FaceGroup& group = current();
        ++faces_;
        for (const tinyobj::index_t& corner : corners) {
            const Corner resolved{resolve(corner.vertex_index, positions.size()),
                                  corner.texcoord_index == 0 ? none : resolve(corner.texcoord_index, uvs.size())};
            const bool lost_uv = corner.texcoord_index != 0 && resolved.uv == none;
            if ((resolved.position == none || lost_uv) && fault.empty())
                fault = "face " + std::to_string(faces_) + " refers to " +
                        (lost_uv ? "texture coordinate " + std::to_string(corner.texcoord_index)
                                 : "vertex " + std::to_string(corner.vertex_index)) +
                        "; there are " + std::to_string(lost_uv ? uvs.size() : positions.size()) + " before it";
            group.corners.push_back(resolved);
        }
        group.corners_of_face.push_back(static_cast<std::uint32_t>(corners.size()));
    }

    double scale_;
    std::string object_, group_, material_;
    std::map<std::tuple<std::string, std::string, std::string>, std::size_t> index_;
    std::uint64_t faces_ = 0;
};

/// Hands the library the MTL files that the OBJ names, and keeps their materials.
class MtlReader : public tinyobj::MaterialReader {
public:
    MtlReader(SceneBuilder& builder, MtlMaterials& materials) : builder_(builder), materials_(materials) {}

    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* into, std::map<std::string, int>* index,
                    std::string* warnings, std::string* errors) override {
        auto path = resource_path(builder_.file(), name);
        if (!path) return fail(path.error());
        path = existing(*path, name);
        if (!path) return true;
        const auto bytes = read_file(*path, limits::import_file_bytes_max);
        if (!bytes) return fail(bytes.error());
        const auto text = checked_mtl(text_of(*bytes));
        if (!text) return fail(bad_input("'" + path->string() + "': " + text.error().sentence));
        std::istringstream stream(*text);
        const std::size_t before = into->size();
        tinyobj::LoadMtl(index, into, &stream, warnings, errors);
        for (std::size_t i = before; i < into->size(); ++i) {
            (*into)[i].name = trimmed((*into)[i].name);
            materials_.know((*into)[i], *path);
        }
        return true;
    }

    const Error* error() const { return error_.sentence.empty() ? nullptr : &error_; }

private:
    bool fail(Error error) {
        if (error_.sentence.empty()) error_ = std::move(error);
        return false;
    }

    /// The file, or one of the same name beside the OBJ; an error after a warning when there is neither.
    Result<std::filesystem::path> existing(const std::filesystem::path& path, const std::string& name) {
        std::error_code ignored;
        if (std::filesystem::is_regular_file(path, ignored)) return path;
        const std::filesystem::path beside = builder_.file().parent_path() / path.filename();
        if (std::filesystem::is_regular_file(beside, ignored)) {
            builder_.warn("the material file '" + name + "' does not exist; '" + beside.filename().string() +
                          "' beside the scene is read");
            return beside;
        }
        builder_.warn("the material file '" + name + "' does not exist; its materials are unknown");
        return bad_input("missing");
    }

    SceneBuilder& builder_;
    MtlMaterials& materials_;
    Error error_{ErrorCode::bad_input, {}};
};

/// Vertices are (position, texture coordinate) pairs; those without a coordinate get (0, 0).
MeshPart assemble(const ObjContent& content, const FaceGroup& group) {
    MeshPart part;
    std::map<Corner, std::uint32_t> placed;
    std::vector<std::uint32_t> face;
    std::vector<Vec3d> outline;
    std::size_t at = 0;
    for (const std::uint32_t corners : group.corners_of_face) {
        face.clear();
        outline.clear();
        for (std::uint32_t i = 0; i < corners; ++i, ++at) {
            const Corner corner = group.corners[at];
            const auto [place, is_new] = placed.emplace(corner, static_cast<std::uint32_t>(part.positions.size()));
            if (is_new) {
                part.positions.push_back(content.positions[corner.position]);
                part.uvs.push_back(corner.uv == none ? Vec2f{} : content.uvs[corner.uv]);
            }
            face.push_back(place->second);
            outline.push_back(content.positions[corner.position]);
        }
        for (const Triangle& t : triangulate(outline)) part.triangles.push_back({face[t[0]], face[t[1]], face[t[2]]});
    }
    return part;
}

std::string object_name(const FaceGroup& group, const SceneBuilder& builder) {
    if (!group.object.empty()) return group.object;
    return group.group.empty() ? builder.file().stem().string() : group.group;
}

Result<void> parse(SceneBuilder& builder, MtlMaterials& materials, ObjContent& content) {
    const auto bytes = read_file(builder.file(), limits::import_file_bytes_max);
    if (!bytes) return bytes.error();
    if (bytes->empty()) return builder.refuse("the file is empty");
    const auto text = checked_obj(text_of(*bytes));
    if (!text) return builder.refuse(text.error().sentence);
    MtlReader reader(builder, materials);
    std::string warnings, errors;
    try {
        std::istringstream stream(*text);
        tinyobj::LoadObjWithCallback(stream, ObjContent::callbacks(), &content, &reader, &warnings, &errors);
    } catch (const std::exception& error) {
        return builder.refuse(std::string("the file cannot be parsed: ") + error.what());
    }
    if (reader.error() != nullptr) return *reader.error();
    if (!content.fault.empty()) return builder.refuse(content.fault);
    return {};
}

}  // namespace

Result<void> read_obj(SceneBuilder& builder, const ImportOptions& options) {
    MtlMaterials materials(builder, options.ke_scale);
    ObjContent content(options.scale);
    if (auto parsed = parse(builder, materials, content); !parsed) return parsed;
    std::map<std::string, int> parts_of_object;
    for (const FaceGroup& group : content.groups) ++parts_of_object[object_name(group, builder)];
    for (const FaceGroup& group : content.groups) {
        MeshPart part = assemble(content, group);
        part.object = object_name(group, builder);
        if (parts_of_object[part.object] > 1)
            part.part = (group.object.empty() || group.group.empty() ? "" : group.group + "/") + group.material;
        const bool closed = materials.depends_on_shape(group.material) && is_closed(part.positions, part.triangles);
        const auto material = materials.compile(group.material, closed);
        if (!material) return material.error();
        part.material = *material;
        if (auto added = builder.add_mesh(std::move(part)); !added) return added;
    }
    return {};
}

}  // namespace lumenfarm::import
