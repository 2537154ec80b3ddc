#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "common/solution/estimate.h"
#include "common/solution/solution.h"
#include "common/solution/surface_point.h"
#include "common/solution/texel_fit.h"
#include "common/solution/triangle_index.h"

#include <cstdint>
#include <vector>

/// k-nearest estimates from kept hits (docs/estimates.md).
namespace lumenfarm {

/// Kept hits around a point on its surface.
struct HitNeighbourhood {
    std::vector<std::uint32_t> hits;  ///< into Solution::kept
    double radius_m = 0;
    double area_m2 = 0;           ///< of the surface within the radius: what lies beyond an edge is not counted
    bool bounded_by_hit = false;  ///< the radius is that of the k-th hit, which is not among `hits`
};

class NearestHits {
public:
    /// REQUIRES: all outlive this; the solution belongs to the scene.
    NearestHits(const Scene& scene, const TriangleIndex& index, const Solution& solution, const TickValue& tick);

    bool empty() const { return order_.empty(); }
    /// The k - 1 nearest hits and the distance of the k-th, or all hits within `radius_max_m` if they are fewer than k.
    /// REQUIRES: k >= 2.
    HitNeighbourhood around(const SurfacePoint& point, std::uint32_t k, double radius_max_m) const;

    /// Sum of the neighbours over their area. With the k-th hit left out the expectation is exact, where k / (pi r^2)
    /// over-estimates by k / (k - 1).
    PointEstimate estimate(const HitNeighbourhood& neighbourhood) const;

    /// Lumens (as a factor of an XYZ tick) that a kept hit stands for: it speaks for all hits that were not kept too.
    const TickValue& tick() const { return tick_; }

private:
    struct Found {
        double distance2;
        std::uint32_t hit;
    };
    struct Search;
    void build(std::uint32_t begin, std::uint32_t end);
    void visit(std::uint32_t begin, std::uint32_t end, Search& search) const;
    double surface_area_m2(const SurfacePoint& point, double radius_m) const;

    const Scene& scene_;
    const TriangleIndex& index_;
    const Solution& solution_;
    TickValue tick_;
    std::vector<Vec3f> positions_;      ///< of the hits in tree order
    std::vector<std::uint32_t> order_;  ///< tree order to Solution::kept
    std::vector<std::uint8_t> axis_;    ///< of the split at each middle
};

}  // namespace lumenfarm
