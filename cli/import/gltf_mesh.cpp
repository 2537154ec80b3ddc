#include "cli/import/gltf_accessor.h"
#include "cli/import/gltf_scene.h"
#include "cli/import/mesh.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace lumenfarm::import {
namespace {

/// Triangles of a list of corners in one of glTF's three modes; leftover corners form none.
std::vector<Triangle> assemble(const std::vector<std::uint32_t>& corners, int mode) {
    std::vector<Triangle> triangles;
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
            triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
        return triangles;
    }
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
        if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
            triangles.push_back({corners[0], corners[i + 1], corners[i + 2]});
        } else {
            const std::size_t odd = i % 2;  // every second triangle of a strip turns the other way
            triangles.push_back({corners[i], corners[i + 1 + odd], corners[i + 2 - odd]});
        }
    }
    return triangles;
}

bool is_triangle_mode(int mode) {
    return mode == TINYGLTF_MODE_TRIANGLES || mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
           mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

}  // namespace

Result<void> GltfMeshes::read_vertices(const tinygltf::Primitive& primitive, const Transform& to_world,
                                       MeshPart& part) const {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end())
        return builder_.refuse("a primitive of object '" + part.object + "' has no POSITION");
    const auto numbers = read_numbers(model_, position->second, 3, builder_);
    if (!numbers) return numbers.error();
    part.positions.reserve(numbers->size() / 3);
    for (std::size_t i = 0; i + 2 < numbers->size(); i += 3)
        part.positions.push_back(to_world.point({(*numbers)[i], (*numbers)[i + 1], (*numbers)[i + 2]}));
    return {};
}

Result<void> GltfMeshes::read_uvs(const tinygltf::Primitive& primitive, MeshPart& part) const {
    const auto use = materials_.texture_use(primitive.material);
    if (!use) return use.error();
    if (!use->has_value()) return {};
    const auto set = primitive.attributes.find("TEXCOORD_" + std::to_string((*use)->tex_coord));
    if (set == primitive.attributes.end())
        return builder_.refuse("object '" + part.object +
                               "' has a material with a picture, but no texture coordinates " +
                               std::to_string((*use)->tex_coord));
    const auto numbers = read_numbers(model_, set->second, 2, builder_);
    if (!numbers) return numbers.error();
    if (numbers->size() / 2 != part.positions.size())
        return builder_.refuse("object '" + part.object + "' has " + std::to_string(numbers->size() / 2) +
                               " texture coordinates for " + std::to_string(part.positions.size()) + " vertices");
    for (std::size_t i = 0; i + 1 < numbers->size(); i += 2)
        part.uvs.push_back((*use)->apply({static_cast<float>((*numbers)[i]), static_cast<float>((*numbers)[i + 1])}));
    return {};
}

Result<void> GltfMeshes::read_triangles(const tinygltf::Primitive& primitive, const Transform& to_world,
                                        MeshPart& part) const {
    std::vector<std::uint32_t> corners(part.positions.size());
    std::iota(corners.begin(), corners.end(), 0u);
    if (primitive.indices >= 0) {
        auto indices = read_indices(model_, primitive.indices, builder_);
        if (!indices) return indices.error();
        corners = std::move(*indices);
        for (const std::uint32_t corner : corners)
            if (corner >= part.positions.size())
                return builder_.refuse("accessor " + std::to_string(primitive.indices) + " of object '" + part.object +
                                       "' has the index " + std::to_string(corner) + "; there are " +
                                       std::to_string(part.positions.size()) + " vertices");
    }
    part.triangles = assemble(corners, primitive.mode);
    if (to_world.mirrors())
        for (Triangle& triangle : part.triangles) std::swap(triangle[1], triangle[2]);
    return {};
}

Result<void> GltfMeshes::add_primitive(const tinygltf::Primitive& primitive, MeshPart part, const Transform& to_world) {
    if (!is_triangle_mode(primitive.mode)) {
        builder_.warn("object '" + part.object + "' has points or lines, which are left out");
        return {};
    }
    if (!primitive.targets.empty()) builder_.warn("object '" + part.object + "' has morph targets, which are left out");
    if (primitive.attributes.count("COLOR_0") > 0)
        builder_.warn("object '" + part.object + "' has vertex colours, which are left out");
    if (primitive.extensions.count("KHR_draco_mesh_compression") > 0)
        return builder_.refuse("object '" + part.object + "' is compressed with Draco, which is not supported");
    if (auto r = read_vertices(primitive, to_world, part); !r) return r;
    if (auto r = read_uvs(primitive, part); !r) return r;
    if (auto r = read_triangles(primitive, to_world, part); !r) return r;
    const bool closed = materials_.depends_on_shape(primitive.material) && is_closed(part.positions, part.triangles);
    const auto material = materials_.compile(primitive.material, closed);
    if (!material) return material.error();
    part.material = *material;
    return builder_.add_mesh(std::move(part));
}

std::string GltfMeshes::part_name(const tinygltf::Mesh& mesh, std::size_t primitive) const {
    const int material = mesh.primitives[primitive].material;
    const auto users = std::count_if(mesh.primitives.begin(), mesh.primitives.end(),
                                     [&](const tinygltf::Primitive& other) { return other.material == material; });
    const bool known = material >= 0 && static_cast<std::size_t>(material) < model_.materials.size();
    const std::string name = known ? model_.materials[static_cast<std::size_t>(material)].name : std::string{};
    return name.empty() || users > 1 ? "primitive " + std::to_string(primitive) : name;
}

Result<void> GltfMeshes::add(int mesh, const std::string& object, const Transform& to_world) {
    if (static_cast<std::size_t>(mesh) >= model_.meshes.size())
        return builder_.refuse("node '" + object + "' refers to mesh " + std::to_string(mesh) + " of " +
                               std::to_string(model_.meshes.size()));
    const tinygltf::Mesh& given = model_.meshes[static_cast<std::size_t>(mesh)];
    for (std::size_t i = 0; i < given.primitives.size(); ++i) {
        MeshPart part;
        part.object = object;
        if (given.primitives.size() > 1) part.part = part_name(given, i);
        if (auto added = add_primitive(given.primitives[i], std::move(part), to_world); !added) return added;
    }
    return {};
}

}  // namespace lumenfarm::import
