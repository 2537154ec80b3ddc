#include "common/transport/clearance.h"

#include "common/octree/octree.h"
#include "common/support/ensure.h"
#include "common/transport/near_part.h"

#include <algorithm>
#include <array>
#include <bit>

namespace lumenfarm {
namespace {

constexpr std::uint32_t coarse_side = 8;
constexpr std::uint32_t fine_side = 64;
constexpr double fine_cell_reaches = 8;  // fine cells are worth their memory where they are this many times the reach
constexpr double enlargement_max = 3;    // of the inradius: beyond it the weights of both triangles differ too much
static_assert(coarse_side * coarse_side == 64);
constexpr std::size_t fine_words = std::size_t{fine_side} * fine_side / 64;

class Finder {
public:
    Finder(const Scene& scene, const ClearanceRules& rules)
        : scene_(scene), rules_(rules), octree_(Octree::make(scene)) {
        const Box box = octree_.box(Octree::root());
        root_ = {(box.low + box.high) * 0.5, (box.high.x - box.low.x) / 2};
    }

    Clearance clearance(std::uint32_t triangle, std::vector<std::uint64_t>& words) const {
        const Slab slab(corners(triangle), rules_.reach_m);
        if (rules_.enlargement_m >= enlargement_max * slab.inradius_m()) return {};
        // Scaling about the incentre by 1 + enlargement / inradius moves no weight by more than that fraction.
        const double slack = rules_.enlargement_m / slab.inradius_m();
        std::array<std::uint64_t, 1> coarse{};
        std::vector<WeightPolygon> parts;
        auto visit = [&](std::uint32_t other) {
            if (other == triangle) return;
            const WeightPolygon part = slab.near_part(corners(other), rules_.edge_band_m);
            if (part.empty()) return;
            slab.mark(part, coarse_side, slack, coarse.data());
            parts.push_back(part);
        };
        visit_near(slab, 0, root_, visit);

        Clearance clearance;
        clearance.least_weight =
            static_cast<float>((rules_.enlargement_m + rules_.edge_band_m) / slab.least_height_m());
        if (parts.empty()) return clearance;
        clearance.first_word = static_cast<std::uint32_t>(words.size());
        if (slab.least_height_m() < fine_cell_reaches * rules_.reach_m * fine_side) {
            clearance.cells_per_side = coarse_side;
            words.push_back(~coarse[0]);
            return clearance;
        }
        std::array<std::uint64_t, fine_words> fine{};
        for (const WeightPolygon& part : parts) slab.mark(part, fine_side, slack, fine.data());
        clearance.cells_per_side = fine_side;
        for (const std::uint64_t word : fine) words.push_back(~word);
        return clearance;
    }

    bool is_clear(Vec3d point) const {
        NearBox box(rules_.reach_m);
        box.add(point);
        bool clear = true;
        auto visit = [&](std::uint32_t triangle) {
            clear = clear && !Slab(corners(triangle), rules_.reach_m).holds(point);
        };
        visit_near(box, 0, root_, visit);
        return clear;
    }

private:
    Corners corners(std::uint32_t triangle) const {
        const Triangle& vertices = scene_.triangles[triangle];
        return {scene_.positions[vertices[0]].as<double>(), scene_.positions[vertices[1]].as<double>(),
                scene_.positions[vertices[2]].as<double>()};
    }

    /// The triangles of the leaves that touch the region; some come several times.
    template <class Region, class Visit>
    void visit_near(const Region& region, std::uint32_t at, const Cube& cube, Visit& visit) const {
        const OctreeNode& node = octree_.nodes()[at];
        if (node.is_empty_leaf() || !region.touches(cube)) return;
        if (node.is_leaf()) {
            for (const std::uint32_t triangle : octree_.triangles(node)) visit(triangle);
            return;
        }
        const double half = cube.half / 2;
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            const Vec3d step{octant & 1 ? half : -half, octant & 2 ? half : -half, octant & 4 ? half : -half};
            visit_near(region, node.first + octant, {cube.centre + step, half}, visit);
        }
    }

    const Scene& scene_;
    ClearanceRules rules_;
    Octree octree_;
    Cube root_;
};

}  // namespace

ClearanceMap ClearanceMap::make(const Scene& scene, const ClearanceRules& rules) {
    ensure(rules.edge_band_m >= rules.reach_m, "the band along edges is as wide as the reach");
    const Finder finder(scene, rules);
    ClearanceMap map;
    map.triangles_.reserve(scene.triangles.size());
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t)
        map.triangles_.push_back(finder.clearance(t, map.words_));
    for (const Light& light : scene.lights)
        map.lights_.push_back(light.kind != LightKind::surface && finder.is_clear(light.position));
    return map;
}

}  // namespace lumenfarm
