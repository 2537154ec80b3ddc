#include "common/solution/nearest_hits.h"

#include "common/solution/disc_area.h"
#include "common/support/ensure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace lumenfarm {
namespace {

constexpr std::uint32_t leaf_hits = 8;

/// Each kept hit is one of a random sample: it stands for hits / kept of them.
TickValue scaled(TickValue tick, const Solution& solution) {
    if (solution.kept.empty()) return tick;
    const double factor = static_cast<double>(solution.balance.hits) / static_cast<double>(solution.kept.size());
    return {tick.watts * factor, tick.lumens * factor};
}

}  // namespace

struct NearestHits::Search {
    const SurfacePoint& point;
    std::uint32_t k;
    double reach2;             ///< nothing beyond is of interest
    std::vector<Found> found;  ///< max-heap by distance
    std::uint32_t last_triangle = none;
    std::optional<std::uint32_t> last_side;

    static bool nearer(const Found& a, const Found& b) {
        return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.hit < b.hit;
    }
    bool belongs(const Scene& scene, const HitRecord& record) {
        if (record.triangle != last_triangle) {
            last_triangle = record.triangle;
            const double distance = nearest_on_triangle(scene, record.triangle, point.position).distance;
            last_side = continuing_side(point, TriangleFrame(scene, record.triangle), distance);
        }
        return last_side && *last_side == record.side();
    }
    void offer(const Found& one) {
        found.push_back(one);
        std::push_heap(found.begin(), found.end(), nearer);
        if (found.size() > k) {
            std::pop_heap(found.begin(), found.end(), nearer);
            found.pop_back();
        }
        if (found.size() == k) reach2 = std::min(reach2, found.front().distance2);
    }
};

NearestHits::NearestHits(const Scene& scene, const TriangleIndex& index, const Solution& solution,
                         const TickValue& tick)
    : scene_(scene),
      index_(index),
      solution_(solution),
      tick_(scaled(tick, solution)),
      positions_(solution.kept.size()),
      order_(solution.kept.size()),
      axis_(solution.kept.size()) {
    for (std::size_t i = 0; i < positions_.size(); ++i)
        positions_[i] = position_of(scene, solution.kept[i].record).as<float>();
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, static_cast<std::uint32_t>(order_.size()));
    std::vector<Vec3f> in_order(positions_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) in_order[i] = positions_[order_[i]];
    positions_ = std::move(in_order);
}

void NearestHits::build(std::uint32_t begin, std::uint32_t end) {
    if (end - begin <= leaf_hits) return;
    Vec3f low = positions_[order_[begin]], high = low;
    for (std::uint32_t i = begin; i < end; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], positions_[order_[i]][axis]);
            high[axis] = std::max(high[axis], positions_[order_[i]][axis]);
        }
    const Vec3f size = high - low;
    const std::uint8_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::uint32_t middle = begin + (end - begin) / 2;
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        return positions_[a][axis] != positions_[b][axis] ? positions_[a][axis] < positions_[b][axis] : a < b;
    };
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, before);
    axis_[middle] = axis;
    build(begin, middle);
    build(middle + 1, end);
}

void NearestHits::visit(std::uint32_t begin, std::uint32_t end, Search& search) const {
    const auto meet = [&](std::uint32_t i) {
        const Vec3d off = positions_[i].as<double>() - search.point.position;
        const double distance2 = dot(off, off);
        if (distance2 <= search.reach2 && search.belongs(scene_, solution_.kept[order_[i]].record))
            search.offer({distance2, order_[i]});
    };
    if (end - begin <= leaf_hits) {
        for (std::uint32_t i = begin; i < end; ++i) meet(i);
        return;
    }
    const std::uint32_t middle = begin + (end - begin) / 2;
    const double off = search.point.position[axis_[middle]] - static_cast<double>(positions_[middle][axis_[middle]]);
    const bool low_first = off < 0;
    if (low_first)
        visit(begin, middle, search);
    else
        visit(middle + 1, end, search);
    if (off * off > search.reach2) return;
    meet(middle);
    if (low_first)
        visit(middle + 1, end, search);
    else
        visit(begin, middle, search);
}

double NearestHits::surface_area_m2(const SurfacePoint& point, double radius_m) const {
    thread_local std::vector<std::uint32_t> triangles;
    triangles.clear();
    index_.near(point.position, radius_m, triangles);
    double area = 0;
    for (const std::uint32_t triangle : triangles) {
        const double distance = nearest_on_triangle(scene_, triangle, point.position).distance;
        if (distance > radius_m || !continuing_side(point, TriangleFrame(scene_, triangle), distance)) continue;
        area += area_within_m2(scene_, triangle, point.position, radius_m);
    }
    return area;
}

HitNeighbourhood NearestHits::around(const SurfacePoint& point, std::uint32_t k, double radius_max_m) const {
    ensure(k >= 2, "at least two hits bound a neighbourhood");
    Search search{point, k, radius_max_m * radius_max_m, {}, none, {}};
    visit(0, static_cast<std::uint32_t>(order_.size()), search);
    HitNeighbourhood around;
    around.bounded_by_hit = search.found.size() == k;
    around.radius_m = radius_max_m;
    if (around.bounded_by_hit) {
        around.radius_m = std::sqrt(search.found.front().distance2);
        std::pop_heap(search.found.begin(), search.found.end(), Search::nearer);
        search.found.pop_back();
    }
    for (const Found& one : search.found) around.hits.push_back(one.hit);
    std::sort(around.hits.begin(), around.hits.end());
    around.area_m2 = surface_area_m2(point, around.radius_m);
    return around;
}

PointEstimate NearestHits::estimate(const HitNeighbourhood& neighbourhood) const {
    PointEstimate estimate;
    estimate.radius_m = neighbourhood.radius_m;
    estimate.hits = neighbourhood.hits.size();
    estimate.standard_error_lx = std::numeric_limits<double>::quiet_NaN();
    if (neighbourhood.hits.empty() || !(neighbourhood.area_m2 > 0)) return estimate;
    const auto& ratios = xyz_ratios();
    constexpr double one = 1 << 20;
    double squares = 0, y_sum = 0, ticks = 0;
    Vec3d xyz;
    for (const std::uint32_t i : neighbourhood.hits) {
        const KeptHit& hit = solution_.kept[i];
        const auto& ratio = ratios[hit.record.wavelength].xyz;
        const double y = hit.energy * (ratio[1] / one);
        xyz = xyz + Vec3d{hit.energy * (ratio[0] / one), y, hit.energy * (ratio[2] / one)};
        squares += y * y;
        y_sum += y;
        ticks += hit.energy;
    }
    const double per_area = 1 / neighbourhood.area_m2;
    estimate.xyz_lx = xyz * (tick_.lumens * per_area);
    estimate.irradiance_w_m2 = ticks * tick_.watts * per_area;
    // the radius is random too: the variance of (k - 1) / A is that of k - 1 hits times (k - 1) / (k - 2)
    const double count = static_cast<double>(neighbourhood.hits.size());
    const double spread = !neighbourhood.bounded_by_hit ? 1 : count > 1 ? count / (count - 1) : 2;
    if (y_sum > 0) estimate.standard_error_lx = std::sqrt(squares * spread) * tick_.lumens * per_area;
    return estimate;
}

}  // namespace lumenfarm
