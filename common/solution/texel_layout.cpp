#include "common/solution/texel_layout.h"

#include "common/support/ensure.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace lumenfarm {
namespace {

double longest_edge_m(const Scene& scene, std::uint32_t triangle) {
    double longest = 0;
    const Triangle& corners = scene.triangles[triangle];
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d edge =
            scene.positions[corners[(i + 1) % 3]].as<double>() - scene.positions[corners[i]].as<double>();
        longest = std::max(longest, length(edge));
    }
    return longest;
}

std::uint32_t rows_for(double edge_m, double texel_m) {
    const double rows = std::ceil(edge_m / texel_m);
    return static_cast<std::uint32_t>(std::clamp(rows, 1.0, static_cast<double>(limits::texel_rows_max)));
}

std::uint64_t texels_for(const Scene& scene, double texel_m) {
    std::uint64_t texels = 0;
    for (std::uint32_t triangle = 0; triangle < scene.triangles.size(); ++triangle) {
        const std::uint64_t rows = rows_for(longest_edge_m(scene, triangle), texel_m);
        texels += 2 * rows * rows;
    }
    return texels;
}

struct CellPlace {
    std::uint32_t row, column;
    bool upper;
};

CellPlace place_of_cell(std::uint32_t cell, std::uint32_t n) {
    const std::uint32_t remaining = n * n - cell;
    auto left = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(remaining))));
    const std::uint32_t row = n - left;
    const std::uint32_t in_row = cell - TexelLayout::first_cell_of_row(row, n);
    return {row, in_row / 2, in_row % 2 == 1};
}

}  // namespace

Result<TexelLayout> TexelLayout::make(const Scene& scene, double texel_m) {
    if (!(texel_m > 0) || !std::isfinite(texel_m))
        return bad_input("the texel size is " + std::to_string(texel_m) + " m; it must be above 0");
    const std::uint64_t texels = texels_for(scene, texel_m);
    if (texels > limits::texels_max) {
        double fits_m = texel_m;
        for (int i = 0; i < 200 && texels_for(scene, fits_m) > limits::texels_max; ++i) fits_m *= 1.5;
        return bad_input("a texel size of " + std::to_string(texel_m) + " m gives " + std::to_string(texels) +
                         " texels; the limit is " + std::to_string(limits::texels_max) + ", " + std::to_string(fits_m) +
                         " m would fit");
    }
    std::vector<std::uint16_t> rows;
    rows.reserve(scene.triangles.size());
    for (std::uint32_t triangle = 0; triangle < scene.triangles.size(); ++triangle)
        rows.push_back(static_cast<std::uint16_t>(rows_for(longest_edge_m(scene, triangle), texel_m)));
    return of_rows(rows, surface_of_triangles(scene), scene.surfaces.size());
}

Result<TexelLayout> TexelLayout::of_rows(const std::vector<std::uint16_t>& rows,
                                         const std::vector<std::uint32_t>& surface_of_triangle, std::size_t surfaces) {
    ensure(rows.size() == surface_of_triangle.size(), "each triangle is of a surface");
    std::uint64_t texels = 0;
    for (const std::uint64_t n : rows) texels += 2 * n * n;
    if (texels > limits::texels_max)
        return bad_input("there are " + std::to_string(texels) + " texels; the limit is " +
                         std::to_string(limits::texels_max));
    TexelLayout layout;
    layout.surfaces_ = surfaces;
    layout.triangles_.reserve(rows.size() + 1);
    std::uint32_t first_texel = 0;
    for (std::size_t triangle = 0; triangle < rows.size(); ++triangle) {
        const std::uint32_t n = rows[triangle];
        ensure(n <= limits::texel_rows_max, "a grid is within its limit");
        Triangle of;
        of.first_texel = first_texel;
        of.rows = n & 0x7ffu;
        of.surface = surface_of_triangle[triangle] & 0x1fffffu;
        layout.triangles_.push_back(of);
        first_texel += 2 * n * n;
    }
    layout.triangles_.emplace_back();
    layout.triangles_.back().first_texel = first_texel;
    return layout;
}

std::vector<std::uint16_t> TexelLayout::rows() const {
    std::vector<std::uint16_t> rows;
    for (std::size_t triangle = 0; triangle + 1 < triangles_.size(); ++triangle)
        rows.push_back(static_cast<std::uint16_t>(triangles_[triangle].rows));
    return rows;
}

Result<TexelLayout> TexelLayout::make(const Scene& scene, const JobSpec& spec) {
    return make(scene, texel_in_force_m(spec, scene));
}

double texel_in_force_m(const JobSpec& spec, const Scene& scene) {
    const Box box = bounding_box(scene);
    return texel_in_force_m(spec, box.empty() ? 0 : length(box.high - box.low));
}

Vec2f TexelLayout::cell_centroid(std::uint32_t cell, std::uint32_t n) {
    const CellPlace place = place_of_cell(cell, n);
    const double shift = place.upper ? 2.0 / 3 : 1.0 / 3;
    return {static_cast<float>((place.row + shift) / n), static_cast<float>((place.column + shift) / n)};
}

bool TexelLayout::is_upper(std::uint32_t cell, std::uint32_t n) { return place_of_cell(cell, n).upper; }

TexelLayout::Place TexelLayout::place_of(std::uint64_t texel) const {
    ensure(texel < texel_count(), "the texel is within the layout");
    const auto after = std::upper_bound(triangles_.begin(), triangles_.end(), texel,
                                        [](std::uint64_t t, const Triangle& of) { return t < of.first_texel; });
    const auto triangle = static_cast<std::uint32_t>(after - triangles_.begin() - 1);
    const auto within = static_cast<std::uint32_t>(texel - triangles_[triangle].first_texel);
    const std::uint32_t cells = rows(triangle) * rows(triangle);
    return {triangle, within / cells, within % cells};
}

}  // namespace lumenfarm
