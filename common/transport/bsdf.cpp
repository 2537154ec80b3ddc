#include "common/transport/bsdf.h"

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

}  // namespace

std::vector<const Material*> materials_by_surface(const Scene& palette, const Scene& geometry) {
    std::vector<const Material*> materials;
    for (const Surface& surface : geometry.surfaces) materials.push_back(&palette.materials[surface.material]);
    return materials;
}

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

Vec2f MaterialTable::uv_at(std::uint32_t triangle, double b1, double b2) const {
    const Triangle& corners = geometry_->triangles[triangle];
    const auto mix = [&](float Vec2f::*axis) {
        return static_cast<float>((1 - b1 - b2) * static_cast<double>(geometry_->uvs[corners[0]].*axis) +
                                  b1 * static_cast<double>(geometry_->uvs[corners[1]].*axis) +
                                  b2 * static_cast<double>(geometry_->uvs[corners[2]].*axis));
    };
    return {mix(&Vec2f::x), mix(&Vec2f::y)};
}

}  // namespace lumenfarm
