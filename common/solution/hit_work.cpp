#include "common/solution/hit_work.h"

#include <algorithm>
#include <array>

namespace lumenfarm {
namespace {

constexpr std::uint64_t texels_apart_max = 4'000'000;

using Corners = std::array<Vec3d, 3>;

/// The texel is a copy of the triangle, n times as small, and an upper one is turned about.
Box box_of_texel(const Corners& triangle, std::uint32_t cell, std::uint32_t n) {
    const Vec2f centroid = TexelLayout::cell_centroid(cell, n);
    const double b1 = centroid.x, b2 = centroid.y;
    const Vec3d centre = triangle[0] + (triangle[1] - triangle[0]) * b1 + (triangle[2] - triangle[0]) * b2;
    const Vec3d middle = (triangle[0] + triangle[1] + triangle[2]) * (1.0 / 3);
    const double scale = (TexelLayout::is_upper(cell, n) ? -1.0 : 1.0) / n;
    Box box{centre, centre};
    for (const Vec3d& corner : triangle)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double reach = centre[axis] + scale * (corner[axis] - middle[axis]);
            box.low[axis] = std::min(box.low[axis], reach);
            box.high[axis] = std::max(box.high[axis], reach);
        }
    return box;
}

}  // namespace

std::vector<SpreadWork> hit_work(const Scene& scene, const TexelLayout& layout, std::span<const TexelSums> texels) {
    const bool by_texel = layout.texel_count() <= texels_apart_max;
    std::vector<SpreadWork> work;
    for (std::uint32_t triangle = 0; triangle < scene.triangles.size(); ++triangle) {
        Corners corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = scene.positions[scene.triangles[triangle][k]].as<double>();
        const std::uint32_t n = layout.rows(triangle);
        std::uint64_t of_triangle = 0;
        for (std::uint32_t cell = 0; cell < n * n; ++cell) {
            std::uint64_t hits = 0;
            for (std::uint32_t side = 0; side < 2; ++side)
                hits += texels[layout.first_texel(triangle, side) + cell].hits;
            of_triangle += hits;
            if (by_texel && hits > 0) work.push_back({box_of_texel(corners, cell, n), static_cast<double>(hits)});
        }
        if (!by_texel && of_triangle > 0)
            work.push_back({box_of_texel(corners, 0, 1), static_cast<double>(of_triangle)});
    }
    return work;
}

std::vector<SpreadWork> corrected_work(std::vector<SpreadWork> planned, std::span<const SpreadWork> measured) {
    double weight = 0;
    for (const SpreadWork& each : planned) weight += each.work;
    for (SpreadWork& each : planned) each.work *= weight > 0 ? planned_hits / weight : 0;
    planned.insert(planned.end(), measured.begin(), measured.end());
    return planned;
}

}  // namespace lumenfarm
