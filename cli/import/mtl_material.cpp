#include "cli/import/mtl_material.h"

#include "cli/import/image.h"
#include "cli/import/optics.h"
#include "cli/import/resource.h"
#include "common/support/limits.h"

#include <algorithm>

namespace lumenfarm::import {
namespace {

constexpr double smooth_exponent = 200;  ///< Ns from which a highlight is taken as a mirror: about 0.1 rad wide
constexpr double default_reflectance = 0.8;
constexpr double default_glass_index = 1.5;

Vec3d colour(const tinyobj::real_t (&rgb)[3]) { return {double(rgb[0]), double(rgb[1]), double(rgb[2])}; }
double largest(Vec3d v) { return std::max({v.x, v.y, v.z}); }
double smallest(Vec3d v) { return std::min({v.x, v.y, v.z}); }

bool mirrors(const tinyobj::material_t& m) { return m.illum == 3 || m.illum == 5 || m.illum == 8; }
bool refracts(const tinyobj::material_t& m) { return m.illum == 4 || m.illum == 6 || m.illum == 7 || m.illum == 9; }

/// The share of the surface that is a glass boundary.
double glass_share(const tinyobj::material_t& m) {
    if (m.dissolve < 1) return 1 - double{m.dissolve};
    return refracts(m) ? 1 : 0;
}

/// Scales both so that no sample of their sum exceeds 1. True when that was needed.
bool conserve(Spectrum& diffuse, Spectrum& mirror) {
    float most = 1;
    for (std::size_t i = 0; i < spectrum_samples; ++i) most = std::max(most, diffuse.samples[i] + mirror.samples[i]);
    if (most <= 1) return false;
    for (std::size_t i = 0; i < spectrum_samples; ++i) {
        diffuse.samples[i] /= most;
        mirror.samples[i] /= most;
    }
    return true;
}

}  // namespace

void MtlMaterials::know(const tinyobj::material_t& material, const std::filesystem::path& folder_file) {
    given_.emplace(material.name, Given{material, folder_file});
}

bool MtlMaterials::depends_on_shape(const std::string& name) const {
    const auto found = given_.find(name);
    return found != given_.end() && glass_share(found->second.material) > 0;
}

Result<ImportedMaterial> MtlMaterials::compile(const std::string& name, bool closed) {
    const std::pair key(name, closed && depends_on_shape(name));
    if (const auto known = compiled_.find(key); known != compiled_.end()) return known->second;
    const auto given = given_.find(name);
    if (given == given_.end()) {
        builder_.warn((name.empty() ? "faces without a material" : "faces of the unknown material '" + name + "'") +
                      " become Lambert reflectors of reflectance 0.8");
        Material grey;
        grey.name = name.empty() ? "no material" : name;
        grey.diffuse.spectrum = builder_.add_spectrum(constant_spectrum(default_reflectance));
        ImportedMaterial made;
        made.index = builder_.add_material(grey);
        return compiled_[key] = made;
    }
    auto made = compile_new(given->second, name, closed);
    if (made) compiled_[key] = *made;
    return made;
}

Result<void> MtlMaterials::check(const tinyobj::material_t& m, const std::string& who) const {
    const struct {
        const char* key;
        Vec3d value;
    } colours[] = {{"Kd", colour(m.diffuse)},
                   {"Ks", colour(m.specular)},
                   {"Ke", colour(m.emission)},
                   {"Tf", colour(m.transmittance)}};
    for (const auto& c : colours)
        if (smallest(c.value) < 0)
            return builder_.refuse(who + " has a negative " + c.key + ": " + std::to_string(smallest(c.value)));
    if (!(m.dissolve >= 0 && m.dissolve <= 1))
        return builder_.refuse(who + " has the dissolve d = " + std::to_string(m.dissolve) +
                               "; it must lie from 0 to 1");
    if (glass_share(m) > 0 && !(m.ior >= 0 && m.ior <= limits::refractive_index_max))
        return builder_.refuse(who + " has the refractive index Ni = " + std::to_string(m.ior) +
                               "; it must lie from 1 to 10");
    return {};
}

void MtlMaterials::set_reflection(const tinyobj::material_t& m, Material& out, const std::string& who) {
    const Vec3d kd = colour(m.diffuse);
    Vec3d ks = colour(m.specular);
    if (largest(kd) > 1 || largest(ks) > 1) builder_.warn(who + " has a reflectance above 1, which was cut to 1");
    const bool smooth = mirrors(m) || (m.illum == 2 && m.shininess >= smooth_exponent);
    if (!smooth) {
        if (m.illum == 2 && largest(ks) > 0)
            builder_.warn(who + " has a broad highlight (Ks with Ns below 200), which is left out");
        ks = {};
    }
    Spectrum diffuse = reflectance_spectrum(kd), mirror = reflectance_spectrum(ks);
    if (conserve(diffuse, mirror))
        builder_.warn(who + " reflects more than it receives (Kd + Ks above 1); both were scaled down");
    if (largest(kd) > 0) out.diffuse.spectrum = builder_.add_spectrum(diffuse);
    if (largest(ks) > 0) out.mirror.spectrum = builder_.add_spectrum(mirror);
}

void MtlMaterials::set_glass(const tinyobj::material_t& m, Material& out, const std::string& who, bool closed) {
    const double share = glass_share(m);
    if (share == 0) return;
    out.dielectric = static_cast<float>(share);
    const Vec3d tint = colour(m.transmittance);
    out.transmission.spectrum = builder_.add_reflectance(largest(tint) > 0 ? tint : Vec3d{1, 1, 1});
    double index = m.ior;
    if (index <= 1 && refracts(m)) {
        builder_.warn(who + " is glass without a refractive index above 1; 1.5 is taken");
        index = default_glass_index;
    }
    out.refractive_index = builder_.add_spectrum(constant_spectrum(std::max(index, 1.0)));
    out.thin = !closed;
    if (closed) builder_.warn(who + " is glass on a closed mesh; the mesh is taken as solid glass");
}

Result<void> MtlMaterials::set_picture(const Given& given, Material& out, const std::string& who) {
    const std::string& name = given.material.diffuse_texname;
    if (name.empty()) return {};
    const auto path = resource_path(given.file, name);
    if (!path) return path.error();
    const Wrap wrap = given.material.diffuse_texopt.clamp ? Wrap::clamp : Wrap::repeat;
    const std::string key = path->string() + (wrap == Wrap::clamp ? " clamped" : "");
    auto known = texture_by_path_.find(key);
    if (known == texture_by_path_.end()) {
        const auto picture = read_picture(*path, name);
        if (!picture) return builder_.refuse(who + ": " + picture.error().sentence);
        Texture texture = to_texture(*picture);
        texture.wrap_u = texture.wrap_v = wrap;
        known = texture_by_path_.emplace(key, builder_.add_texture(std::move(texture))).first;
    }
    if (out.diffuse.spectrum == none)
        builder_.warn(who + " has a picture (map_Kd), but Kd 0 0 0: it stays black");
    else
        out.diffuse.texture = known->second;
    return {};
}

void MtlMaterials::warn_of_rest(const tinyobj::material_t& m, const std::string& who) {
    const struct {
        const char* key;
        const std::string& name;
    } maps[] = {
        {"map_Ka", m.ambient_texname},  {"map_Ks", m.specular_texname},   {"map_Ns", m.specular_highlight_texname},
        {"map_Bump", m.bump_texname},   {"disp", m.displacement_texname}, {"map_d", m.alpha_texname},
        {"refl", m.reflection_texname}, {"map_Pr", m.roughness_texname},  {"map_Pm", m.metallic_texname},
        {"map_Ps", m.sheen_texname},    {"map_Ke", m.emissive_texname},   {"norm", m.normal_texname}};
    for (const auto& map : maps)
        if (!map.name.empty()) builder_.warn(who + " has the map " + map.key + ", which is left out");
    if (m.metallic > 0) builder_.warn(who + " has Pm (metallic), which is left out");
}

Result<ImportedMaterial> MtlMaterials::compile_new(const Given& given, const std::string& name, bool closed) {
    const tinyobj::material_t& m = given.material;
    const std::string who = "material '" + name + "'";
    if (auto checked = check(m, who); !checked) return checked.error();
    Material out;
    out.name = name;
    set_reflection(m, out, who);
    set_glass(m, out, who, closed);
    if (auto picture = set_picture(given, out, who); !picture) return picture.error();
    warn_of_rest(m, who);
    ImportedMaterial made;
    const Vec3d emission = colour(m.emission);
    made.luminance = luminance_of(emission) * ke_scale_;
    if (made.luminance > limits::photometric_max)
        return builder_.refuse(who + " emits " + std::to_string(made.luminance) + " cd/m2; the limit is 1e15");
    if (made.luminance > 0) made.emission_spectrum = builder_.add_light_spectrum(emission);
    made.index = builder_.add_material(std::move(out));
    return made;
}

}  // namespace lumenfarm::import
