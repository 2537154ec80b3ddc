#include "cli/import/mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace lumenfarm::import {
namespace {

std::vector<std::uint32_t> weld(std::span<const Vec3d> positions) {
    std::map<std::tuple<double, double, double>, std::uint32_t> first_at;
    std::vector<std::uint32_t> welded(positions.size());
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        const Vec3d p = positions[i];
        welded[i] = first_at.emplace(std::tuple(p.x, p.y, p.z), i).first->second;
    }
    return welded;
}

/// A polygon in the plane of its largest extent, counter-clockwise.
struct Flat {
    std::vector<double> x, y;
    double turn(std::size_t a, std::size_t b, std::size_t c) const {
        return (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a]);
    }
};

/// Drops the axis along which Newell's normal is largest.
Flat flatten(std::span<const Vec3d> corners) {
    Vec3d normal;
    for (std::size_t i = 0; i < corners.size(); ++i)
        normal = normal + cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
    std::size_t axis = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
    const double sign = normal[axis] < 0 ? -1 : 1;
    Flat flat;
    for (const Vec3d corner : corners) {
        flat.x.push_back(sign * corner[(axis + 1) % 3]);
        flat.y.push_back(corner[(axis + 2) % 3]);
    }
    return flat;
}

bool is_convex(const Flat& flat) {
    const std::size_t n = flat.x.size();
    for (std::size_t i = 0; i < n; ++i)
        if (flat.turn(i, (i + 1) % n, (i + 2) % n) < 0) return false;
    return true;
}

/// True when the corner `at` of the ring is convex and no other corner of the ring lies in its triangle.
bool is_ear(const Flat& flat, const std::vector<std::uint32_t>& ring, std::size_t at) {
    const std::size_t n = ring.size();
    const std::uint32_t a = ring[(at + n - 1) % n], b = ring[at], c = ring[(at + 1) % n];
    if (flat.turn(a, b, c) <= 0) return false;
    return std::none_of(ring.begin(), ring.end(), [&](std::uint32_t p) {
        return p != a && p != b && p != c && flat.turn(a, b, p) >= 0 && flat.turn(b, c, p) >= 0 &&
               flat.turn(c, a, p) >= 0;
    });
}

}  // namespace

bool is_closed(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
    const std::vector<std::uint32_t> welded = weld(positions);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const Triangle& t : triangles) {
        const Triangle w{welded[t[0]], welded[t[1]], welded[t[2]]};
        if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue;
        for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(w[i], w[(i + 1) % 3]);
    }
    std::sort(edges.begin(), edges.end());
    if (edges.empty() || std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return false;
    return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
        return std::binary_search(edges.begin(), edges.end(), std::pair(edge.second, edge.first));
    });
}

std::vector<Triangle> triangulate(std::span<const Vec3d> corners) {
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> ring(corners.size());
    std::iota(ring.begin(), ring.end(), 0u);
    const Flat flat = flatten(corners);
    const bool convex = is_convex(flat);
    while (ring.size() > 3 && !convex) {
        std::size_t ear = 0;
        while (ear < ring.size() && !is_ear(flat, ring, ear)) ++ear;
        if (ear == ring.size()) break;  // not simple: the rest becomes a fan
        const std::size_t n = ring.size();
        triangles.push_back({ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]});
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) triangles.push_back({ring[0], ring[i], ring[i + 1]});
    return triangles;
}

}  // namespace lumenfarm::import
