#include "common/transport/clearance.h"

#include "common/octree/octree.h"
#include "common/support/ensure.h"
#include "common/support/limits.h"
#include "common/transport/enlarged_triangle.h"
#include "common/transport/near_part.h"

#include <algorithm>
#include <array>
#include <thread>

namespace lumenfarm {
namespace {

constexpr std::uint32_t leaf_triangles = 16;  // of the octree in which neighbours are looked up
constexpr std::uint32_t coarse_side = 8;
constexpr std::uint32_t fine_side = 64;
constexpr double fine_share = 1.0 / 4096;  // fine cells are for triangles that hold this much of the scene's area
constexpr double edge_bands_max = 2;       // shallow parts widen the band along the edges up to this many times
// neighbours looked at before a triangle counts as clear nowhere: some, and more for those that hold much of the
// scene's area. Fans of very many triangles about one corner would take the square of their number.
constexpr double visits_each = 512;
constexpr double visits_shared = 16;
static_assert(coarse_side * coarse_side == 64);
constexpr std::size_t fine_words = std::size_t{fine_side} * fine_side / 64;

class Finder {
public:
    Finder(const Scene& scene, const ClearanceRules& rules, std::uint32_t threads)
        : scene_(scene),
          rules_(rules),
          octree_(Octree::make(scene, {.leaf_objects = leaf_triangles, .threads = threads})) {
        const Box box = octree_.box(Octree::root());
        root_ = {(box.low + box.high) * 0.5, (box.high.x - box.low.x) / 2};
        for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
            const Corners c = corners(t);
            double_area_m2_ += length(cross(c[1] - c[0], c[2] - c[0]));
        }
    }

    Clearance clearance(std::uint32_t triangle, std::vector<std::uint64_t>& words) const {
        const Corners own = corners(triangle);
        if (enlarged(own, rules_.enlargement_m).sliver) return {};
        const Slab slab(own, rules_.reach_m);
        // Scaling about the incentre by 1 + enlargement / inradius moves no weight by more than that fraction.
        const double slack = rules_.enlargement_m / slab.inradius_m();
        const double share = slab.double_area_m2() / double_area_m2_;
        const std::uint32_t side = share >= fine_share ? fine_side : coarse_side;
        const double visits_max = visits_each + visits_shared * share * static_cast<double>(scene_.triangles.size());
        double visits = 0;
        double band_m = rules_.edge_band_m;
        bool marked = false;
        std::array<std::uint64_t, fine_words> near{};
        auto visit = [&](std::uint32_t other) {
            if (++visits > visits_max) return false;
            if (other == triangle) return true;
            const WeightPolygon part = slab.near_part(corners(other), rules_.edge_band_m);
            if (part.empty()) return true;
            const double needed_m = slab.depth_m(part) + rules_.reach_m;
            if (needed_m <= edge_bands_max * rules_.edge_band_m) {
                band_m = std::max(band_m, needed_m);
                return true;
            }
            slab.mark(part, side, slack, near.data());
            marked = true;
            return true;
        };
        if (!visit_near(slab, 0, root_, visit)) return {};

        Clearance clearance;
        clearance.least_weight = static_cast<float>((rules_.enlargement_m + band_m) / slab.least_height_m());
        if (!marked) return clearance;
        clearance.first_word = static_cast<std::uint32_t>(words.size());
        clearance.cells_per_side = side;
        for (std::size_t w = 0; w < side * side / 64; ++w) words.push_back(~near[w]);
        return clearance;
    }

    bool is_clear(Vec3d point) const {
        NearBox box(rules_.reach_m);
        box.add(point);
        auto visit = [&](std::uint32_t triangle) { return !Slab(corners(triangle), rules_.reach_m).holds(point); };
        return visit_near(box, 0, root_, visit);
    }

private:
    Corners corners(std::uint32_t triangle) const {
        const Triangle& vertices = scene_.triangles[triangle];
        return {scene_.positions[vertices[0]].as<double>(), scene_.positions[vertices[1]].as<double>(),
                scene_.positions[vertices[2]].as<double>()};
    }

    /// The triangles of the leaves that touch the region; some come several times. Ends where a visit returns false.
    template <class Region, class Visit>
    bool visit_near(const Region& region, std::uint32_t at, const Cube& cube, Visit& visit) const {
        const OctreeNode& node = octree_.nodes()[at];
        if (node.is_empty_leaf() || !region.touches(cube)) return true;
        if (node.is_leaf()) return std::ranges::all_of(octree_.triangles(node), visit);
        const double half = cube.half / 2;
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            const Vec3d step{octant & 1 ? half : -half, octant & 2 ? half : -half, octant & 4 ? half : -half};
            if (!visit_near(region, node.first + octant, {cube.centre + step, half}, visit)) return false;
        }
        return true;
    }

    const Scene& scene_;
    ClearanceRules rules_;
    Octree octree_;
    Cube root_;
    double double_area_m2_ = 0;  ///< of the scene
};

}  // namespace

ClearanceMap ClearanceMap::make(const Scene& scene, const ClearanceRules& rules) {
    ensure(rules.edge_band_m >= rules.reach_m, "the band along edges is as wide as the reach");
    const std::uint32_t threads = std::clamp(std::thread::hardware_concurrency(), 1u, limits::octree_threads_max);
    const Finder finder(scene, rules, threads);
    ClearanceMap map;
    map.triangles_.resize(scene.triangles.size());
    // each thread takes a run of triangles and keeps its own words, which are joined in the order of triangles
    std::vector<std::vector<std::uint64_t>> words(threads);
    const auto first_of = [&](std::size_t run) { return run * scene.triangles.size() / threads; };
    const auto find = [&](std::size_t run) {
        for (std::size_t t = first_of(run); t < first_of(run + 1); ++t)
            map.triangles_[t] = finder.clearance(static_cast<std::uint32_t>(t), words[run]);
    };
    {
        std::vector<std::jthread> helpers;
        for (std::size_t run = 1; run < threads; ++run) helpers.emplace_back(find, run);
        find(0);
    }
    for (std::size_t run = 0; run < threads; ++run) {
        const auto before = static_cast<std::uint32_t>(map.words_.size());
        for (std::size_t t = first_of(run); t < first_of(run + 1); ++t)
            if (map.triangles_[t].cells_per_side > 1) map.triangles_[t].first_word += before;
        map.words_.insert(map.words_.end(), words[run].begin(), words[run].end());
    }
    for (const Light& light : scene.lights)
        map.lights_.push_back(light.kind != LightKind::surface && finder.is_clear(light.position));
    return map;
}

}  // namespace lumenfarm
