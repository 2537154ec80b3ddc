#include "cli/import/gltf_scene.h"
#include "cli/import/gltf_spectra.h"
#include "cli/import/optics.h"
#include "common/support/limits.h"

#include <cmath>
#include <numbers>

namespace lumenfarm::import {
namespace {

/// The node's -Z axis in the world; nothing when the transform flattens it.
Result<Vec3d> forward_of(const Transform& to_world, const std::string& who, const SceneBuilder& builder) {
    const Vec3d forward = -to_world.columns[2];
    if (!(length(forward) > 0) || !std::isfinite(length(forward)))
        return builder.refuse(who + " has a node whose transform has no direction");
    return normalize(forward);
}

Result<void> set_cone(const tinygltf::SpotLight& spot, const std::string& who, const SceneBuilder& builder,
                      Light& light) {
    const double inner = spot.innerConeAngle, outer = spot.outerConeAngle;
    if (!(inner >= 0 && inner < outer && outer <= std::numbers::pi / 2 + 1e-6))
        return builder.refuse(who + " has the cone angles " + std::to_string(inner) + " (inner) and " +
                              std::to_string(outer) + " (outer); 0 <= inner < outer <= pi/2 must hold");
    light.kind = LightKind::spot;
    light.cos_inner = std::cos(inner);
    light.cos_outer = std::max(0.0, std::cos(outer));
    return {};
}

}  // namespace

Result<void> add_gltf_light(const tinygltf::Model& model, int light, const std::string& node_name,
                            const Transform& to_world, SceneBuilder& builder) {
    if (light < 0 || static_cast<std::size_t>(light) >= model.lights.size())
        return builder.refuse("node '" + node_name + "' refers to light " + std::to_string(light) + " of " +
                              std::to_string(model.lights.size()));
    const tinygltf::Light& given = model.lights[static_cast<std::size_t>(light)];
    const std::string who = gltf_name("light", static_cast<std::size_t>(light), given.name);
    if (given.type != "point" && given.type != "spot") {
        builder.warn(who + " is of the kind '" + given.type + "', which is left out");
        return {};
    }
    Vec3d colour{1, 1, 1};
    if (given.color.size() == 3) colour = {given.color[0], given.color[1], given.color[2]};
    const bool valid = colour.x >= 0 && colour.y >= 0 && colour.z >= 0 && luminance_of(colour) <= 1e6;
    if (!valid || (!given.color.empty() && given.color.size() != 3) ||
        !(given.intensity >= 0 && given.intensity <= limits::photometric_max))
        return builder.refuse(who +
                              " must have a colour of three numbers >= 0 and an intensity >= 0; the intensity is " +
                              std::to_string(given.intensity));
    const auto spectra = read_given_spectra(given.extras);
    if (!spectra) return builder.refuse(who + ": " + spectra.error().sentence);
    Light made;
    made.name = node_name;
    made.kind = LightKind::point;
    made.photometric = given.intensity * luminance_of(colour);
    if (!(made.photometric > 0)) {
        builder.warn(who + " has no intensity and is left out");
        return {};
    }
    made.spectrum = spectra->emission ? builder.add_spectrum(*spectra->emission) : builder.add_light_spectrum(colour);
    made.position = to_world.columns[3];
    made.lambertian = spectra->lambertian && given.type == "point";
    const auto forward = forward_of(to_world, who, builder);
    if (!forward) return forward.error();
    made.direction = *forward;
    if (given.type == "spot")
        if (auto cone = set_cone(given.spot, who, builder, made); !cone) return cone;
    builder.add_light(std::move(made));
    return {};
}

Result<void> add_gltf_camera(const tinygltf::Model& model, int camera, const std::string& node_name,
                             const Transform& to_world, SceneBuilder& builder) {
    if (static_cast<std::size_t>(camera) >= model.cameras.size())
        return builder.refuse("node '" + node_name + "' refers to camera " + std::to_string(camera) + " of " +
                              std::to_string(model.cameras.size()));
    const tinygltf::Camera& given = model.cameras[static_cast<std::size_t>(camera)];
    const std::string who = gltf_name("camera", static_cast<std::size_t>(camera), given.name);
    if (given.type != "perspective") {
        builder.warn(who + " is not a perspective camera and is left out");
        return {};
    }
    Camera made;
    made.name = node_name;
    made.position = to_world.columns[3];
    const auto forward = forward_of(to_world, who, builder);
    if (!forward) return forward.error();
    made.forward = *forward;
    const Vec3d up = to_world.columns[1] - made.forward * dot(made.forward, to_world.columns[1]);
    if (!(length(up) > 0)) return builder.refuse(who + " has a node whose transform has no upward direction");
    made.up = normalize(up);
    made.vertical_fov_degrees = given.perspective.yfov * 180 / std::numbers::pi;
    made.aspect = given.perspective.aspectRatio == 0 ? 1 : given.perspective.aspectRatio;
    builder.add_camera(std::move(made));
    return {};
}

}  // namespace lumenfarm::import
