#include "common/transport/near_part.h"

#include <algorithm>
#include <cmath>

namespace lumenfarm {

void NearBox::add(Vec3d point) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low_[axis] = std::min(low_[axis], point[axis] - reach_m_);
        high_[axis] = std::max(high_[axis], point[axis] + reach_m_);
    }
}

bool NearBox::touches(const Cube& cube) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (low_[axis] > cube.centre[axis] + cube.half || high_[axis] < cube.centre[axis] - cube.half) return false;
    return true;
}

bool NearBox::touches(const Corners& c) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (low_[axis] > std::max({c[0][axis], c[1][axis], c[2][axis]})) return false;
        if (high_[axis] < std::min({c[0][axis], c[1][axis], c[2][axis]})) return false;
    }
    return true;
}

WeightPolygon WeightPolygon::below(double Corner::*member, double sign, double bound) const {
    WeightPolygon part;
    for (std::size_t k = 0; k < size_; ++k) {
        const Corner& here = corners_[k];
        const Corner& next = corners_[k + 1 < size_ ? k + 1 : 0];
        const double over = sign * here.*member - bound;
        const double next_over = sign * next.*member - bound;
        if (over <= 0) part.add(here);
        if ((over <= 0) == (next_over <= 0)) continue;
        const double at = over / (over - next_over);
        part.add({here.b1 + at * (next.b1 - here.b1), here.b2 + at * (next.b2 - here.b2),
                  here.height + at * (next.height - here.height)});
    }
    return part;
}

Slab::Slab(const Corners& corners, double reach_m) : near_(reach_m), reach_m_(reach_m), corner_(corners[0]) {
    for (const Vec3d& corner : corners) near_.add(corner);
    const Vec3d edge1 = corners[1] - corners[0];
    const Vec3d edge2 = corners[2] - corners[0];
    const Vec3d across = cross(edge1, edge2);
    double_area_m2_ = length(across);
    normal_ = across * (1 / double_area_m2_);
    slopes_[1] = cross(edge2, normal_) * (1 / double_area_m2_);
    slopes_[2] = cross(normal_, edge1) * (1 / double_area_m2_);
    slopes_[0] = -(slopes_[1] + slopes_[2]);
    for (std::size_t k = 0; k < 3; ++k) steepness_[k] = length(slopes_[k]);
}

double Slab::inradius_m() const { return 1 / (steepness_[0] + steepness_[1] + steepness_[2]); }
double Slab::least_height_m() const { return 1 / *std::max_element(steepness_.begin(), steepness_.end()); }

bool Slab::touches(const Cube& cube) const {
    if (!near_.touches(cube)) return false;
    const double half_height = cube.half * (std::abs(normal_.x) + std::abs(normal_.y) + std::abs(normal_.z));
    return std::abs(dot(normal_, cube.centre - corner_)) <= reach_m_ + half_height;
}

bool Slab::holds(Vec3d point) const {
    const Vec3d from = point - corner_;
    if (std::abs(dot(normal_, from)) > reach_m_) return false;
    const std::array<double, 3> weights{1 + dot(slopes_[0], from), dot(slopes_[1], from), dot(slopes_[2], from)};
    for (std::size_t k = 0; k < 3; ++k)
        if (weights[k] < -reach_m_ * steepness_[k]) return false;
    return true;
}

double Slab::depth_m(const WeightPolygon& points) const {
    std::array<double, 3> most{-1e300, -1e300, -1e300};
    for (const WeightPolygon::Corner& p : points) {
        most[0] = std::max(most[0], 1 - p.b1 - p.b2);
        most[1] = std::max(most[1], p.b1);
        most[2] = std::max(most[2], p.b2);
    }
    return std::min({most[0] / steepness_[0], most[1] / steepness_[1], most[2] / steepness_[2]});
}

WeightPolygon Slab::near_part(const Corners& other, double edge_band_m) const {
    if (!near_.touches(other)) return {};
    WeightPolygon whole;
    double low = 1e300;
    double high = -1e300;
    for (const Vec3d& corner : other) {
        const Vec3d from = corner - corner_;
        const double height = dot(normal_, from);
        low = std::min(low, height);
        high = std::max(high, height);
        whole.add({dot(slopes_[1], from), dot(slopes_[2], from), height});
    }
    const double shallow = edge_band_m - reach_m_;
    if (low > reach_m_ || high < -reach_m_ || depth_m(whole) <= shallow) return {};
    const WeightPolygon inside =
        whole.below(&WeightPolygon::Corner::height, 1, reach_m_).below(&WeightPolygon::Corner::height, -1, reach_m_);
    return depth_m(inside) <= shallow ? WeightPolygon{} : inside;
}

void Slab::mark(const WeightPolygon& near, std::uint32_t side, double weight_slack, std::uint64_t* words) const {
    const double more1 = reach_m_ * steepness_[1] + weight_slack;
    const double more2 = reach_m_ * steepness_[2] + weight_slack;
    double low1 = 1e300;
    double high1 = -1e300;
    for (const WeightPolygon::Corner& p : near) {
        low1 = std::min(low1, p.b1);
        high1 = std::max(high1, p.b1);
    }
    const auto cell = [&](double weight) {
        return static_cast<std::int64_t>(std::floor(std::clamp(weight, -1.0, 2.0) * side));
    };
    const std::int64_t last = side - 1;
    for (std::int64_t i = std::max<std::int64_t>(0, cell(low1 - more1)); i <= std::min(last, cell(high1 + more1));
         ++i) {
        // the row of cells with b1 in [i, i + 1] / side
        const double row_low = static_cast<double>(i) / side - more1;
        const double row_high = static_cast<double>(i + 1) / side + more1;
        const WeightPolygon row =
            near.below(&WeightPolygon::Corner::b1, 1, row_high).below(&WeightPolygon::Corner::b1, -1, -row_low);
        double low2 = 1e300;
        double high2 = -1e300;
        for (const WeightPolygon::Corner& p : row) {
            low2 = std::min(low2, p.b2);
            high2 = std::max(high2, p.b2);
        }
        for (std::int64_t j = std::max<std::int64_t>(0, cell(low2 - more2)); j <= std::min(last, cell(high2 + more2));
             ++j) {
            const auto bit = static_cast<std::uint64_t>(i * side + j);
            words[bit / 64] |= std::uint64_t{1} << (bit % 64);
        }
    }
}

}  // namespace lumenfarm
