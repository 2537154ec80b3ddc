#include "common/transport/bsdf.h"

#include "common/math/sampling.h"
#include "common/transport/fresnel.h"

#include <algorithm>
#include <cmath>

namespace lumenfarm {
namespace {

std::uint32_t wrapped(std::int64_t index, std::int64_t size, Wrap wrap) {
    if (wrap == Wrap::clamp) return static_cast<std::uint32_t>(std::clamp<std::int64_t>(index, 0, size - 1));
    const std::int64_t period = wrap == Wrap::repeat ? size : 2 * size;
    std::int64_t i = index % period;
    if (i < 0) i += period;
    return static_cast<std::uint32_t>(i < size ? i : 2 * size - 1 - i);
}

Lobes glass_lobes(const MaterialTable& materials, const Material& material, const Incidence& incidence) {
    const double index = materials.refractive_index(material, incidence.bin);
    const double tint = materials.albedo(material.transmission, incidence.bin, [&] { return incidence.uv; });
    Lobes lobes;
    lobes.first_kind = Lobes::Kind::mirror;
    if (material.thin) {
        lobes.second_kind = Lobes::Kind::straight;
        lobes.first = sheet_reflectance(fresnel(incidence.cos_incident, index).reflectance);
    } else {
        lobes.second_kind = Lobes::Kind::refracted;
        lobes.relative_index = incidence.back ? 1 / index : index;
        const FresnelSplit split = fresnel(incidence.cos_incident, lobes.relative_index);
        lobes.first = split.reflectance;
        lobes.cos_transmitted = split.cos_transmitted;
    }
    lobes.second = (1 - lobes.first) * tint;
    return lobes;
}

}  // namespace

double MaterialTable::texture_albedo(std::uint32_t index, std::uint32_t bin, Vec2f uv) const {
    const Texture& texture = scene_->textures[index];
    const double x = static_cast<double>(uv.x) * texture.width - 0.5;
    const double y = static_cast<double>(uv.y) * texture.height - 0.5;
    // far outside the texture a float has no fraction left: the texel is then as good as any
    if (!(std::abs(x) < 1e15) || !(std::abs(y) < 1e15)) return reflectance_at(texture.texels[0], bin);
    const auto i = static_cast<std::int64_t>(std::floor(x));
    const auto j = static_cast<std::int64_t>(std::floor(y));
    const double fx = x - static_cast<double>(i);
    const double fy = y - static_cast<double>(j);
    const auto texel = [&](std::int64_t column, std::int64_t row) {
        const std::size_t at = std::size_t{wrapped(row, texture.height, texture.wrap_v)} * texture.width +
                               wrapped(column, texture.width, texture.wrap_u);
        return reflectance_at(texture.texels[at], bin);
    };
    const double low = texel(i, j) * (1 - fx) + texel(i + 1, j) * fx;
    const double high = texel(i, j + 1) * (1 - fx) + texel(i + 1, j + 1) * fx;
    return low * (1 - fy) + high * fy;
}

Lobes choose_lobes(const MaterialTable& materials, const Material& material, const Incidence& incidence, double& chance) {
    const double glass = static_cast<double>(material.dielectric);
    if (chance < glass) {
        chance /= glass;
        return glass_lobes(materials, material, incidence);
    }
    if (glass > 0) chance = (chance - glass) / (1 - glass);
    const auto uv = [&] { return incidence.uv; };
    Lobes lobes;
    lobes.first = materials.albedo(material.diffuse, incidence.bin, uv);
    lobes.second = materials.albedo(material.mirror, incidence.bin, uv);
    return lobes;
}

Vec3d scattered_direction(const Lobes& lobes, Lobes::Kind kind, const Incidence& in, double u, double v) {
    switch (kind) {
        case Lobes::Kind::lambert: return frame_about(in.normal).to_world(sample_cosine_hemisphere(u, v));
        case Lobes::Kind::mirror: return normalize(in.direction + in.normal * (2 * in.cos_incident));
        case Lobes::Kind::straight: return in.direction;
        case Lobes::Kind::refracted: {
            const double eta = 1 / lobes.relative_index;
            return normalize(in.direction * eta + in.normal * (eta * in.cos_incident - lobes.cos_transmitted));
        }
    }
    return in.direction;
}

}  // namespace lumenfarm
