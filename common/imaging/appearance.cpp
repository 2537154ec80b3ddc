#include "common/imaging/appearance.h"

#include "common/spectrum/cie.h"

namespace lumenfarm {
namespace {

constexpr std::uint32_t bins_per_weight = 100;  // 10 nm

Vec3d xyz_of(const Spectrum& spectrum) {
    return {integral(spectrum, cie_x()), integral(spectrum, cie_y()), integral(spectrum, cie_z())};
}

}  // namespace

Appearance::Appearance(const Scene& scene, const Emission& emission)
    : scene_(scene),
      materials_(scene),
      surface_of_triangle_(surface_of_triangles(scene)),
      emitted_(scene.surfaces.size()) {
    Vec3d sum;
    for (std::uint32_t bin = bins_per_weight / 2; bin < wavelength_bins; bin += bins_per_weight) {
        const double power = value_at(illuminant_d65(), bin);
        const Vec3d xyz{power * value_at(cie_x(), bin), power * value_at(cie_y(), bin), power * value_at(cie_z(), bin)};
        weights_.push_back({bin, xyz_to_linear_srgb(xyz)});
        sum = sum + weights_.back().rgb;
    }
    for (Weight& weight : weights_) weight.rgb = {weight.rgb.x / sum.x, weight.rgb.y / sum.y, weight.rgb.z / sum.z};
    plain_.reserve(scene.spectra.size());
    for (std::uint32_t i = 0; i < scene.spectra.size(); ++i) plain_.push_back(integrate({i, none}, {}));

    Vec3d white;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        const Vec3d xyz = xyz_of(scene.spectra[light.spectrum]);
        if (!(xyz.y > 0)) continue;
        const Vec3d rgb = xyz_to_linear_srgb(xyz * (1 / xyz.y));
        white = white + rgb * emission.lights[i].flux_lm;
        if (light.kind == LightKind::surface)
            emitted_[light.surface] = emitted_[light.surface] + rgb * light.photometric;
    }
    if (emission.flux_lm > 0) light_white_ = white * (1 / emission.flux_lm);
}

Vec3d Appearance::integrate(const ColorSlot& slot, Vec2f uv) const {
    Vec3d rgb;
    for (const Weight& weight : weights_)
        rgb = rgb + weight.rgb * materials_.albedo(slot, weight.bin, [&] { return uv; });
    return rgb;
}

Vec3d Appearance::albedo(const ColorSlot& slot, Vec2f uv) const {
    if (slot.spectrum == none) return {};
    return slot.texture == none ? plain_[slot.spectrum] : integrate(slot, uv);
}

Vec3d Appearance::emitted(std::uint32_t surface, std::uint32_t side) const {
    if (side == 1 && !scene_.materials[scene_.surfaces[surface].material].double_sided) return {};
    return emitted_[surface];
}

Vec2f Appearance::uv_at(std::uint32_t triangle, double b1, double b2) const {
    if (scene_.uvs.empty()) return {};
    const Triangle& corners = scene_.triangles[triangle];
    const auto mix = [&](float a, float b, float c) {
        return static_cast<float>(static_cast<double>(a) * (1 - b1 - b2) + static_cast<double>(b) * b1 +
                                  static_cast<double>(c) * b2);
    };
    const Vec2f a = scene_.uvs[corners[0]], b = scene_.uvs[corners[1]], c = scene_.uvs[corners[2]];
    return {mix(a.x, b.x, c.x), mix(a.y, b.y, c.y)};
}

}  // namespace lumenfarm
