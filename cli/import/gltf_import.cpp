#include "cli/import/gltf_scene.h"
#include "cli/import/gltf_value.h"
#include "cli/import/readers.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>

namespace lumenfarm::import {
namespace {

bool all_finite(const std::vector<double>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); });
}

/// Rotation by a quaternion x, y, z, w, which is normalised first. [glTF 2.0, 3.5.3]
void rotate(Transform& t, const std::vector<double>& q) {
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double x = q[0] / norm, y = q[1] / norm, z = q[2] / norm, w = q[3] / norm;
    t.columns[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)};
    t.columns[1] = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)};
    t.columns[2] = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)};
}

Result<Transform> local_transform(const tinygltf::Node& node, const std::string& who, const SceneBuilder& builder) {
    const auto has = [&](const std::vector<double>& list, std::size_t size) {
        return list.empty() || (list.size() == size && all_finite(list));
    };
    if (!has(node.matrix, 16) || !has(node.translation, 3) || !has(node.scale, 3) || !has(node.rotation, 4))
        return builder.refuse(who + " has a transform of a wrong size or with numbers that are not finite");
    Transform t;
    if (!node.matrix.empty()) {
        const std::vector<double>& m = node.matrix;
        if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
            return builder.refuse(who + " has a matrix that is not affine: its last row must be 0 0 0 1");
        for (std::size_t c = 0; c < 4; ++c) t.columns[c] = {m[4 * c], m[4 * c + 1], m[4 * c + 2]};
        return t;
    }
    if (!node.rotation.empty()) {
        if (std::all_of(node.rotation.begin(), node.rotation.end(), [](double n) { return n == 0; }))
            return builder.refuse(who + " has the rotation 0 0 0 0, which is none");
        rotate(t, node.rotation);
    }
    for (std::size_t c = 0; c < 3 && !node.scale.empty(); ++c) t.columns[c] = t.columns[c] * node.scale[c];
    if (!node.translation.empty()) t.columns[3] = {node.translation[0], node.translation[1], node.translation[2]};
    return t;
}

/// Walks the nodes from the roots of the scene. A node has one parent, so meeting it again is a cycle or damage.
class NodeWalk {
public:
    NodeWalk(const tinygltf::Model& model, SceneBuilder& builder)
        : model_(model), builder_(builder), meshes_(model, builder), visited_(model.nodes.size()) {}

    Result<void> visit(int index, const Transform& parent, std::size_t depth) {
        if (index < 0 || static_cast<std::size_t>(index) >= model_.nodes.size())
            return builder_.refuse("node " + std::to_string(index) + " does not exist; there are " +
                                   std::to_string(model_.nodes.size()));
        const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(index)];
        const std::string who = gltf_name("node", static_cast<std::size_t>(index), node.name);
        if (visited_[static_cast<std::size_t>(index)])
            return builder_.refuse(who + " is reached twice: the nodes form a cycle or share a child");
        if (depth > limits::node_depth_max)
            return builder_.refuse(who + " lies deeper than " + std::to_string(limits::node_depth_max) + " levels");
        visited_[static_cast<std::size_t>(index)] = true;
        const auto local = local_transform(node, who, builder_);
        if (!local) return local.error();
        const Transform to_world = parent.after(*local);
        if (auto placed = place(node, index, to_world); !placed) return placed;
        for (const int child : node.children)
            if (auto below = visit(child, to_world, depth + 1); !below) return below;
        return {};
    }

private:
    Result<void> place(const tinygltf::Node& node, int index, const Transform& to_world) {
        if (node.skin >= 0) builder_.warn("node " + std::to_string(index) + " has a skin, which is left out");
        if (node.mesh >= 0)
            if (auto r = meshes_.add(node.mesh, name_of(node, index, node.mesh, model_.meshes), to_world); !r) return r;
        if (node.camera >= 0)
            if (auto r = add_gltf_camera(model_, node.camera, name_of(node, index, node.camera, model_.cameras),
                                         to_world, builder_);
                !r)
                return r;
        const auto lights = node.extensions.find("KHR_lights_punctual");
        if (lights == node.extensions.end()) return {};
        const tinygltf::Value* light = member(lights->second, "light");
        if (light == nullptr || !light->IsInt())
            return builder_.refuse("node " + std::to_string(index) +
                                   " has no number of a light in KHR_lights_punctual");
        const int number = light->GetNumberAsInt();
        return add_gltf_light(model_, number, name_of(node, index, number, model_.lights), to_world, builder_);
    }

    /// The name that the user knows: the node's, else that of what it carries, else its number.
    template <class T>
    std::string name_of(const tinygltf::Node& node, int index, int carried, const std::vector<T>& list) const {
        if (!node.name.empty()) return node.name;
        const auto place = static_cast<std::size_t>(carried);
        if (place < list.size() && !list[place].name.empty()) return list[place].name;
        return "node " + std::to_string(index);
    }

    const tinygltf::Model& model_;
    SceneBuilder& builder_;
    GltfMeshes meshes_;
    std::vector<bool> visited_;
};

/// Roots of the default scene, or of the first; without scenes, all nodes that are nobody's child.
Result<std::vector<int>> roots(const tinygltf::Model& model, SceneBuilder& builder) {
    if (!model.scenes.empty()) {
        const int chosen = model.defaultScene < 0 ? 0 : model.defaultScene;
        if (static_cast<std::size_t>(chosen) >= model.scenes.size())
            return builder.refuse("the default scene is " + std::to_string(chosen) + "; there are " +
                                  std::to_string(model.scenes.size()));
        if (model.scenes.size() > 1)
            builder.warn("the file has " + std::to_string(model.scenes.size()) + " scenes; number " +
                         std::to_string(chosen) + " is read");
        return model.scenes[static_cast<std::size_t>(chosen)].nodes;
    }
    std::vector<bool> is_child(model.nodes.size());
    for (const tinygltf::Node& node : model.nodes)
        for (const int child : node.children)
            if (child >= 0 && static_cast<std::size_t>(child) < is_child.size())
                is_child[static_cast<std::size_t>(child)] = true;
    std::vector<int> free;
    for (std::size_t i = 0; i < is_child.size(); ++i)
        if (!is_child[i]) free.push_back(static_cast<int>(i));
    return free;
}

}  // namespace

Result<void> read_gltf(SceneBuilder& builder) {
    const auto model = load_gltf(builder);
    if (!model) return model.error();
    if (!model->animations.empty()) builder.warn("the file has animations, which are left out");
    const auto start = roots(*model, builder);
    if (!start) return start.error();
    NodeWalk walk(*model, builder);
    for (const int root : *start)
        if (auto visited = walk.visit(root, Transform{}, 0); !visited) return visited;
    return {};
}

}  // namespace lumenfarm::import
