#include "cli/import/gltf_material.h"

#include "cli/import/gltf_value.h"
#include "cli/import/optics.h"
#include "common/support/limits.h"

#include <algorithm>

namespace lumenfarm::import {

/// What the file says of a material, checked.
struct GltfMaterials::Factors {
    Vec3d base{1, 1, 1};
    std::uint32_t texture = none;
    double metallic = 1, roughness = 1;
    double specular = 1;
    double ior = 1.5;
    double abbe_inverse = 0;  ///< 0 is no dispersion
    double transmission = 0;
    double thickness = 0;
    Vec3d emission;  ///< luminance of each linear sRGB primary [cd/m2]
};

namespace {

constexpr double smooth_roughness = 0.1;   ///< up to here a lobe is taken as a mirror
constexpr double notable_roughness = 0.5;  ///< under it, a gloss that is left out is worth a warning
constexpr double default_reflectance = 0.8;
constexpr double dispersion_scale = 20;  ///< KHR_materials_dispersion: 20 / Abbe number

const tinygltf::Value& extension(const tinygltf::Material& material, const char* name) {
    static const tinygltf::Value nothing;
    const auto found = material.extensions.find(name);
    return found == material.extensions.end() ? nothing : found->second;
}

Spectrum scaled(const Spectrum& spectrum, double factor) {
    Spectrum result;
    std::transform(spectrum.samples.begin(), spectrum.samples.end(), result.samples.begin(),
                   [&](float s) { return static_cast<float>(s * factor); });
    return result;
}

Spectrum plus(Spectrum a, const Spectrum& b) {
    for (std::size_t i = 0; i < spectrum_samples; ++i) a.samples[i] += b.samples[i];
    return a;
}

bool any(Vec3d v) { return v.x > 0 || v.y > 0 || v.z > 0; }

}  // namespace

GltfMaterials::GltfMaterials(const tinygltf::Model& model, SceneBuilder& builder)
    : model_(model), builder_(builder), textures_(model, builder) {}

Error GltfMaterials::refuse(const std::string& who, const Error& error) const {
    return builder_.refuse(who + ": " + error.sentence);
}

Result<ImportedMaterial> GltfMaterials::compile(int material, bool closed) {
    const std::pair key(material, closed && depends_on_shape(material));
    if (const auto known = compiled_.find(key); known != compiled_.end()) return known->second;
    if (material < 0) return compiled_[key] = compile_default();
    const auto index = static_cast<std::size_t>(material);
    if (index >= model_.materials.size())
        return builder_.refuse("a primitive refers to material " + std::to_string(material) + " of " +
                               std::to_string(model_.materials.size()));
    const tinygltf::Material& given = model_.materials[index];
    auto made = compile_new(given, gltf_name("material", index, given.name), closed);
    if (made) compiled_[key] = *made;
    return made;
}

bool GltfMaterials::depends_on_shape(int material) const {
    if (material < 0 || static_cast<std::size_t>(material) >= model_.materials.size()) return false;
    const tinygltf::Material& m = model_.materials[static_cast<std::size_t>(material)];
    const auto positive = [&](const char* name, const char* key) {
        const tinygltf::Value* value = member(extension(m, name), key);
        return value != nullptr && value->IsNumber() && value->GetNumberAsDouble() > 0;
    };
    return positive("KHR_materials_transmission", "transmissionFactor") &&
           !positive("KHR_materials_volume", "thicknessFactor");
}

Result<std::optional<TextureUse>> GltfMaterials::texture_use(int material) const {
    if (material < 0 || static_cast<std::size_t>(material) >= model_.materials.size())
        return std::optional<TextureUse>{};
    const auto& info = model_.materials[static_cast<std::size_t>(material)].pbrMetallicRoughness.baseColorTexture;
    if (info.index < 0) return std::optional<TextureUse>{};
    auto use = textures_.use(info);
    if (!use) return use.error();
    return std::optional<TextureUse>(*use);
}

ImportedMaterial GltfMaterials::compile_default() {
    builder_.warn("primitives without a material become Lambert reflectors of reflectance 0.8");
    Material grey;
    grey.name = "no material";
    grey.diffuse.spectrum = builder_.add_spectrum(constant_spectrum(default_reflectance));
    ImportedMaterial made;
    made.index = builder_.add_material(grey);
    return made;
}

Result<GltfMaterials::Factors> GltfMaterials::read_factors(const tinygltf::Material& m, const std::string& who) const {
    Factors f;
    const tinygltf::PbrMetallicRoughness& pbr = m.pbrMetallicRoughness;
    const auto unit = [](double v) { return v >= 0 && v <= 1; };
    if (pbr.baseColorFactor.size() < 3 || !std::all_of(pbr.baseColorFactor.begin(), pbr.baseColorFactor.end(), unit))
        return builder_.refuse(who + ": baseColorFactor must be numbers from 0 to 1");
    if (!unit(pbr.metallicFactor) || !unit(pbr.roughnessFactor))
        return builder_.refuse(who + ": metallicFactor is " + std::to_string(pbr.metallicFactor) +
                               " and roughnessFactor " + std::to_string(pbr.roughnessFactor) +
                               "; they must lie from 0 to 1");
    f.base = {pbr.baseColorFactor[0], pbr.baseColorFactor[1], pbr.baseColorFactor[2]};
    f.metallic = pbr.metallicFactor;
    f.roughness = pbr.roughnessFactor;
    double dispersion = 0, strength = 1;
    const struct {
        const char *extension, *key;
        double otherwise, low, high;
        double& into;
    } numbers[] = {
        {"KHR_materials_specular", "specularFactor", 1, 0, 1, f.specular},
        {"KHR_materials_ior", "ior", 1.5, 1, limits::refractive_index_max, f.ior},
        {"KHR_materials_transmission", "transmissionFactor", 0, 0, 1, f.transmission},
        {"KHR_materials_volume", "thicknessFactor", 0, 0, limits::coordinate_max_m, f.thickness},
        {"KHR_materials_dispersion", "dispersion", 0, 0, 100, dispersion},
        {"KHR_materials_emissive_strength", "emissiveStrength", 1, 0, limits::photometric_max, strength},
    };
    for (const auto& n : numbers) {
        const auto value = number_member(extension(m, n.extension), n.key, n.otherwise, n.low, n.high);
        if (!value) return refuse(who, value.error());
        n.into = *value;
    }
    f.abbe_inverse = dispersion / dispersion_scale;
    if (m.emissiveFactor.size() != 3 || !std::all_of(m.emissiveFactor.begin(), m.emissiveFactor.end(), unit))
        return builder_.refuse(who + ": emissiveFactor must be three numbers from 0 to 1");
    f.emission = Vec3d{m.emissiveFactor[0], m.emissiveFactor[1], m.emissiveFactor[2]} * strength;
    return f;
}

void GltfMaterials::set_reflection(const Factors& f, Material& out, const std::string& who) {
    const bool smooth = f.roughness <= smooth_roughness;
    const Spectrum base = reflectance_spectrum(f.base);
    double metal = f.metallic;
    double gloss = 0;
    if (metal > 0 && !smooth) {
        builder_.warn(who + " is a rough metal; it becomes a Lambert reflector of its base colour");
        metal = 0;
    } else if (metal < 1 && f.roughness < notable_roughness && f.transmission < 1) {
        gloss = smooth ? normal_reflectance(f.ior) * f.specular : 0;
        builder_.warn(who + (smooth ? " is a smooth non-metal; its gloss becomes a mirror of constant reflectance"
                                    : " is glossy; it becomes a Lambert reflector of its base colour"));
    }
    const bool mixed_texture = f.texture != none && metal > 0 && metal < 1;
    if (mixed_texture) {
        builder_.warn(who + " is partly metal and has a picture; its gloss is left out");
        gloss = 0;
    }
    if (metal < 1) out.diffuse = {builder_.add_spectrum(scaled(base, (1 - metal) * (1 - gloss))), f.texture};
    const Spectrum mirror = plus(scaled(base, metal), constant_spectrum((1 - metal) * gloss));
    if (metal > 0 || gloss > 0) out.mirror = {builder_.add_spectrum(mirror), metal > 0 ? f.texture : none};
}

void GltfMaterials::set_glass(const Factors& f, Material& out, const std::string& who, bool closed) {
    if (f.transmission == 0) return;
    if (f.roughness > smooth_roughness) builder_.warn(who + " is rough glass; it becomes smooth glass");
    out.dielectric = static_cast<float>(f.transmission);
    out.transmission = {builder_.add_reflectance(f.base), f.texture};
    const Spectrum index = f.abbe_inverse > 0 ? cauchy_index(f.ior, 1 / f.abbe_inverse) : constant_spectrum(f.ior);
    Spectrum bounded = index;
    for (float& n : bounded.samples) n = std::clamp(n, 1.0f, static_cast<float>(limits::refractive_index_max));
    if (!(bounded == index))
        builder_.warn(who + " has so much dispersion that its refractive index was held in [1, 10]");
    out.refractive_index = builder_.add_spectrum(bounded);
    out.thin = f.thickness == 0 && !closed;
    if (f.thickness == 0 && closed)
        builder_.warn(who + " is glass without a thickness on a closed mesh; the mesh is taken as solid glass");
}

void GltfMaterials::set_given(const GivenSpectra& given, Material& out) {
    if (given.diffuse) out.diffuse = {builder_.add_spectrum(*given.diffuse), none};
    if (given.mirror) out.mirror = {builder_.add_spectrum(*given.mirror), none};
    if (given.transmission) out.transmission = {builder_.add_spectrum(*given.transmission), none};
    if (given.refractive_index) out.refractive_index = builder_.add_spectrum(*given.refractive_index);
}

Result<void> GltfMaterials::set_emission(const tinygltf::Material& material, const Factors& f,
                                         const GivenSpectra& given, ImportedMaterial& out, const std::string& who) {
    Vec3d emission = f.emission;
    if (any(emission) && material.emissiveTexture.index >= 0) {
        const auto mean = textures_.mean(material.emissiveTexture.index);
        if (!mean) return mean.error();
        emission = {emission.x * mean->x, emission.y * mean->y, emission.z * mean->z};
        builder_.warn(who + " has an emissive picture; its mean colour is emitted everywhere");
    }
    out.luminance = given.luminance_cd_m2.value_or(luminance_of(emission));
    if (given.emission && !(out.luminance > 0))
        return builder_.refuse(who + " has an emission spectrum, but no luminance: give luminance_cd_m2");
    if (!(out.luminance > 0)) return {};
    out.emission_spectrum = given.emission ? builder_.add_spectrum(*given.emission)
                                           : builder_.add_light_spectrum(any(emission) ? emission : Vec3d{1, 1, 1});
    return {};
}

void GltfMaterials::warn_of_rest(const tinygltf::Material& m, const std::string& who) {
    if (m.alphaMode != "OPAQUE") builder_.warn(who + " has the alpha mode " + m.alphaMode + "; it is taken as opaque");
    if (m.normalTexture.index >= 0) builder_.warn(who + " has a normal map, which is left out");
    if (m.pbrMetallicRoughness.metallicRoughnessTexture.index >= 0)
        builder_.warn(who + " has a metallic-roughness map; only its factors are used");
    if (member(extension(m, "KHR_materials_volume"), "attenuationDistance") != nullptr)
        builder_.warn(who + " absorbs light inside its volume; this is left out");
    for (const char* map : {"transmissionTexture", "specularTexture", "specularColorTexture", "thicknessTexture"})
        for (const auto& [name, value] : m.extensions)
            if (member(value, map) != nullptr) builder_.warn(who + " has a " + map + ", which is left out");
    if (member(extension(m, "KHR_materials_specular"), "specularColorFactor") != nullptr)
        builder_.warn(who + " has a specular colour, which is left out");
    for (const char* name :
         {"KHR_materials_clearcoat", "KHR_materials_sheen", "KHR_materials_iridescence", "KHR_materials_anisotropy",
          "KHR_materials_unlit", "KHR_materials_diffuse_transmission", "KHR_materials_pbrSpecularGlossiness"})
        if (m.extensions.count(name) > 0) builder_.warn(who + " uses " + name + ", which is left out");
}

Result<ImportedMaterial> GltfMaterials::compile_new(const tinygltf::Material& m, const std::string& who, bool closed) {
    auto factors = read_factors(m, who);
    if (!factors) return factors.error();
    const auto given = read_given_spectra(m.extras);
    if (!given) return refuse(who, given.error());
    if (m.pbrMetallicRoughness.baseColorTexture.index >= 0) {
        const auto texture = textures_.texture(m.pbrMetallicRoughness.baseColorTexture.index);
        if (!texture) return texture.error();
        factors->texture = *texture;
    }
    Material out;
    out.name = m.name.empty() ? who : m.name;
    out.double_sided = m.doubleSided;
    set_reflection(*factors, out, who);
    set_glass(*factors, out, who, closed);
    set_given(*given, out);
    ImportedMaterial made;
    if (auto emission = set_emission(m, *factors, *given, made, who); !emission) return emission.error();
    warn_of_rest(m, who);
    made.index = builder_.add_material(std::move(out));
    return made;
}

}  // namespace lumenfarm::import
