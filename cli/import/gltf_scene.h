#pragma once

#include "cli/import/gltf_material.h"
#include "cli/import/transform.h"

/// The parts that nodes of a glTF file place in the world. Errors: bad_input with the element.
namespace lumenfarm::import {

class GltfMeshes {
public:
    GltfMeshes(const tinygltf::Model& model, SceneBuilder& builder)
        : model_(model), builder_(builder), materials_(model, builder) {}
    /// `object`: the name of the node that carries the mesh.
    Result<void> add(int mesh, const std::string& object, const Transform& to_world);

private:
    /// The material's name where only this primitive of the mesh has it, else "primitive 2".
    std::string part_name(const tinygltf::Mesh& mesh, std::size_t primitive) const;
    Result<void> add_primitive(const tinygltf::Primitive& primitive, MeshPart part, const Transform& to_world);
    Result<void> read_vertices(const tinygltf::Primitive& primitive, const Transform& to_world, MeshPart& part) const;
    Result<void> read_uvs(const tinygltf::Primitive& primitive, MeshPart& part) const;
    Result<void> read_triangles(const tinygltf::Primitive& primitive, const Transform& to_world, MeshPart& part) const;

    const tinygltf::Model& model_;
    SceneBuilder& builder_;
    GltfMaterials materials_;
};

Result<void> add_gltf_light(const tinygltf::Model& model, int light, const std::string& node_name,
                            const Transform& to_world, SceneBuilder& builder);
Result<void> add_gltf_camera(const tinygltf::Model& model, int camera, const std::string& node_name,
                             const Transform& to_world, SceneBuilder& builder);

}  // namespace lumenfarm::import
