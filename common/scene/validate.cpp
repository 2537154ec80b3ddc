#include "common/scene/scene_file.h"
#include "common/scene/text.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

namespace lumenfarm {
namespace {

constexpr double unit_tolerance = 1e-6;
constexpr double albedo_tolerance = 1e-6;  ///< rounding of float sums of two reflectances

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

/// "surface 3 ('wall')"
std::string element(const char* kind, std::size_t index, const std::string& name = {}) {
    std::string text = std::string(kind) + " " + std::to_string(index);
    return name.empty() ? text : text + " ('" + clean_name(name) + "')";
}

bool within(double value, double low, double high) { return value >= low && value <= high; }

bool finite_position(Vec3d p) {
    const double most = limits::coordinate_max_m;
    return within(p.x, -most, most) && within(p.y, -most, most) && within(p.z, -most, most);
}

bool is_unit(Vec3d v) { return std::abs(dot(v, v) - 1) <= 2 * unit_tolerance; }

Result<void> count_at_most(const char* what, std::uint64_t count, std::uint64_t most) {
    if (count <= most) return {};
    return bad_input("the scene has " + std::to_string(count) + " " + what + "; the limit is " + std::to_string(most));
}

Result<void> validate_counts(const Scene& scene) {
    const struct {
        const char* what;
        std::uint64_t count, most;
    } counts[] = {{"vertices", scene.positions.size(), limits::vertices_max},
                  {"triangles", scene.triangles.size(), limits::triangles_max},
                  {"surfaces", scene.surfaces.size(), limits::surfaces_max},
                  {"materials", scene.materials.size(), limits::materials_max},
                  {"spectra", scene.spectra.size(), limits::spectra_max},
                  {"textures", scene.textures.size(), limits::textures_max},
                  {"lights", scene.lights.size(), limits::lights_max},
                  {"cameras", scene.cameras.size(), limits::cameras_max}};
    for (const auto& c : counts)
        if (auto result = count_at_most(c.what, c.count, c.most); !result) return result;
    if (scene.triangles.empty()) return bad_input("the scene has no triangles");
    return {};
}

Result<void> validate_vertices(const Scene& scene) {
    for (std::size_t i = 0; i < scene.positions.size(); ++i) {
        const Vec3d p = scene.positions[i].as<double>();
        if (!finite_position(p))
            return bad_input(element("vertex", i) + " lies at (" + number(p.x) + ", " + number(p.y) + ", " +
                             number(p.z) + ") m; coordinates must lie within 1e7 m");
    }
    if (!scene.uvs.empty() && scene.uvs.size() != scene.positions.size())
        return bad_input("the scene has " + std::to_string(scene.uvs.size()) + " texture coordinates for " +
                         std::to_string(scene.positions.size()) + " vertices");
    for (std::size_t i = 0; i < scene.uvs.size(); ++i) {
        const Vec2f uv = scene.uvs[i];
        if (!within(uv.x, -limits::uv_max, limits::uv_max) || !within(uv.y, -limits::uv_max, limits::uv_max))
            return bad_input(element("vertex", i) + " has texture coordinates (" + number(uv.x) + ", " + number(uv.y) +
                             "); they must lie within 1e6");
    }
    return {};
}

Result<void> validate_triangles(const Scene& scene) {
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        for (const std::uint32_t vertex : scene.triangles[t])
            if (vertex >= scene.positions.size())
                return bad_input(element("triangle", t) + " refers to vertex " + std::to_string(vertex) + " of " +
                                 std::to_string(scene.positions.size()));
        if (!(triangle_area_m2(scene, t) > 0)) return bad_input(element("triangle", t) + " has zero area");
    }
    return {};
}

Result<void> validate_surfaces(const Scene& scene) {
    std::unordered_set<std::string> names;
    std::uint64_t next = 0;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
        const Surface& s = scene.surfaces[i];
        const std::string who = element("surface", i, s.name);
        if (s.name.empty() || !is_clean_name(s.name) || !is_clean_name(s.object))
            return bad_input(who + " must have a name, as UTF-8 text without control characters");
        if (!names.insert(s.name).second) return bad_input(who + " has the name of an earlier surface");
        if (s.first_triangle != next || s.triangle_count == 0)
            return bad_input(who + " has triangles from " + std::to_string(s.first_triangle) + ", " +
                             std::to_string(s.triangle_count) + " of them; expected some from " + std::to_string(next));
        if (s.material >= scene.materials.size())
            return bad_input(who + " refers to material " + std::to_string(s.material) + " of " +
                             std::to_string(scene.materials.size()));
        next += s.triangle_count;
    }
    if (next == scene.triangles.size()) return {};
    return bad_input("the surfaces have " + std::to_string(next) + " triangles and the scene " +
                     std::to_string(scene.triangles.size()));
}

/// Every sample of `spectrum` in [low, high].
Result<void> samples_within(const Spectrum& spectrum, double low, double high, const std::string& what) {
    for (std::size_t i = 0; i < spectrum_samples; ++i)
        if (!within(spectrum.samples[i], low, high))
            return bad_input(what + " is " + number(spectrum.samples[i]) + " at " +
                             number(wavelength_min_nm + sample_step_nm * static_cast<double>(i)) +
                             " nm; it must lie between " + number(low) + " and " + number(high));
    return {};
}

Result<void> validate_slot(const Scene& scene, const ColorSlot& slot, const std::string& what) {
    if (slot.texture != none && slot.texture >= scene.textures.size())
        return bad_input(what + " refers to texture " + std::to_string(slot.texture) + " of " +
                         std::to_string(scene.textures.size()));
    if (slot.texture != none && scene.uvs.empty())
        return bad_input(what + " has a texture, but the scene has no texture coordinates");
    if (slot.spectrum == none) return {};
    if (slot.spectrum >= scene.spectra.size())
        return bad_input(what + " refers to spectrum " + std::to_string(slot.spectrum) + " of " +
                         std::to_string(scene.spectra.size()));
    return samples_within(scene.spectra[slot.spectrum], 0, 1, what);
}

/// diffuse + mirror <= 1 at every sample; textures only lower them.
Result<void> validate_albedo(const Scene& scene, const Material& material, const std::string& who) {
    if (material.diffuse.spectrum == none || material.mirror.spectrum == none) return {};
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        const double sum = double{scene.spectra[material.diffuse.spectrum].samples[i]} +
                           scene.spectra[material.mirror.spectrum].samples[i];
        if (!(sum <= 1 + albedo_tolerance))
            return bad_input(who + " reflects more than it receives: diffuse and mirror add up to " + number(sum));
    }
    return {};
}

Result<void> validate_dielectric(const Scene& scene, const Material& material, const std::string& who) {
    if (!within(material.dielectric, 0, 1))
        return bad_input(who + " has a dielectric share of " + number(material.dielectric) +
                         "; it must lie between 0 and 1");
    if (material.refractive_index == none && material.dielectric == 0) return {};
    if (material.refractive_index >= scene.spectra.size())
        return bad_input(who + " is a dielectric, but its refractive index is not among the " +
                         std::to_string(scene.spectra.size()) + " spectra");
    return samples_within(scene.spectra[material.refractive_index], 1, limits::refractive_index_max,
                          who + ": refractive index");
}

Result<void> validate_materials(const Scene& scene) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& m = scene.materials[i];
        const std::string who = element("material", i, m.name);
        if (!is_clean_name(m.name)) return bad_input(who + " must have a name without control characters");
        if (auto r = validate_slot(scene, m.diffuse, who + ": diffuse"); !r) return r;
        if (auto r = validate_slot(scene, m.mirror, who + ": mirror"); !r) return r;
        if (auto r = validate_slot(scene, m.transmission, who + ": transmission"); !r) return r;
        if (auto r = validate_albedo(scene, m, who); !r) return r;
        if (auto r = validate_dielectric(scene, m, who); !r) return r;
    }
    return {};
}

Result<void> validate_spectra(const Scene& scene) {
    for (std::size_t i = 0; i < scene.spectra.size(); ++i)
        if (auto r = samples_within(scene.spectra[i], 0, limits::light_sample_max, element("spectrum", i)); !r)
            return r;
    return {};
}

Result<void> validate_textures(const Scene& scene) {
    std::uint64_t total = 0;
    for (std::size_t i = 0; i < scene.textures.size(); ++i) {
        const Texture& t = scene.textures[i];
        const std::string who = element("texture", i);
        if (t.width < 1 || t.height < 1 || t.width > limits::texture_side_max || t.height > limits::texture_side_max)
            return bad_input(who + " has " + std::to_string(t.width) + " x " + std::to_string(t.height) +
                             " texels; each side must have 1 to " + std::to_string(limits::texture_side_max));
        if (t.texels.size() != std::uint64_t{t.width} * t.height)
            return bad_input(who + " has " + std::to_string(t.texels.size()) + " texels; its sides ask for " +
                             std::to_string(std::uint64_t{t.width} * t.height));
        if (t.wrap_u > Wrap::clamp || t.wrap_v > Wrap::clamp) return bad_input(who + " has an unknown wrap mode");
        for (const SigmoidCoefficients& c : t.texels)
            if (!std::isfinite(c.c0) || !std::isfinite(c.c1) || !std::isfinite(c.c2))
                return bad_input(who + " has a coefficient that is not finite");
        total += t.texels.size();
    }
    return count_at_most("texels in textures", total, limits::texture_texels_max);
}

Result<void> validate_punctual(const Light& light, const std::string& who) {
    if (!finite_position(light.position)) return bad_input(who + " must lie within 1e7 m");
    if (!is_unit(light.direction)) return bad_input(who + " must have a direction of length 1");
    const bool cone = within(light.cos_inner, -1, 1) && within(light.cos_outer, -1, 1);
    if (!cone || light.cos_outer > light.cos_inner || light.cos_outer == 1)
        return bad_input(who + " has the cone cosines " + number(light.cos_inner) + " (inner) and " +
                         number(light.cos_outer) + " (outer); the outer cone must be wider than the inner and than 0");
    return {};
}

Result<void> validate_light(const Scene& scene, const Light& light, const std::string& who) {
    if (!is_clean_name(light.name)) return bad_input(who + " must have a name without control characters");
    if (light.kind > LightKind::spot) return bad_input(who + " is of an unknown kind");
    if (!(light.photometric > 0 && light.photometric <= limits::photometric_max))
        return bad_input(who + " has the luminance or intensity " + number(light.photometric) +
                         "; it must be above 0 and at most 1e15");
    if (light.spectrum >= scene.spectra.size())
        return bad_input(who + " has no spectrum among the " + std::to_string(scene.spectra.size()) + " of the scene");
    const auto& samples = scene.spectra[light.spectrum].samples;
    if (std::all_of(samples.begin(), samples.end(), [](float s) { return s == 0; }))
        return bad_input(who + " has a spectrum that is zero everywhere");
    if (light.kind == LightKind::surface && light.surface >= scene.surfaces.size())
        return bad_input(who + " refers to surface " + std::to_string(light.surface) + " of " +
                         std::to_string(scene.surfaces.size()));
    return validate_punctual(light, who);
}

Result<void> validate_lights(const Scene& scene) {
    std::unordered_set<std::uint32_t> emitting;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        const std::string who = element("light", i, light.name);
        if (auto r = validate_light(scene, light, who); !r) return r;
        if (light.kind == LightKind::surface && !emitting.insert(light.surface).second)
            return bad_input(who + " is the second light of surface " + std::to_string(light.surface));
    }
    return {};
}

Result<void> validate_cameras(const Scene& scene) {
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
        const Camera& c = scene.cameras[i];
        const std::string who = element("camera", i, c.name);
        if (!is_clean_name(c.name)) return bad_input(who + " must have a name without control characters");
        if (!finite_position(c.position)) return bad_input(who + " must lie within 1e7 m");
        if (!is_unit(c.forward) || !is_unit(c.up) || !(length(cross(c.forward, c.up)) > unit_tolerance))
            return bad_input(who + " must have forward and up directions of length 1 that are not parallel");
        if (!(c.vertical_fov_degrees > 0 && c.vertical_fov_degrees < 180))
            return bad_input(who + " has a field of view of " + number(c.vertical_fov_degrees) +
                             " degrees; it must be above 0 and below 180");
        if (!within(c.aspect, 1 / limits::aspect_max, limits::aspect_max))
            return bad_input(who + " has an aspect ratio of " + number(c.aspect) + "; it must lie in [0.001, 1000]");
    }
    return {};
}

}  // namespace

Result<void> validate_geometry(const Scene& scene) {
    auto vertices = validate_vertices(scene);
    return vertices ? validate_triangles(scene) : vertices;
}

Result<void> validate(const Scene& scene) {
    for (const auto check : {validate_counts, validate_geometry, validate_surfaces, validate_spectra, validate_textures,
                             validate_materials, validate_lights, validate_cameras})
        if (auto result = check(scene); !result) return result;
    return {};
}

}  // namespace lumenfarm
