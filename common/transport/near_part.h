#pragma once

#include "common/transport/enlarged_triangle.h"

#include <array>
#include <cstddef>
#include <cstdint>

/// The part of a triangle that comes near another one, seen in the other's barycentric weights.
namespace lumenfarm {

struct Cube {
    Vec3d centre;
    double half = 0;
};

/// The box about some points, larger by the reach.
class NearBox {
public:
    explicit NearBox(double reach_m) : reach_m_(reach_m) {}
    void add(Vec3d point);
    bool touches(const Cube& cube) const;
    bool touches(const Corners& corners) const;

private:
    double reach_m_;
    Vec3d low_{1e300, 1e300, 1e300}, high_{-1e300, -1e300, -1e300};
};

/// A convex polygon near a triangle: of each corner the weights b1, b2 of its foot on the plane, and its height over
/// it.
class WeightPolygon {
public:
    struct Corner {
        double b1, b2, height;
    };
    void add(const Corner& corner) { corners_[size_++] = corner; }
    bool empty() const { return size_ == 0; }
    const Corner* begin() const { return corners_.data(); }
    const Corner* end() const { return corners_.data() + size_; }
    /// The part where sign * member <= bound.
    WeightPolygon below(double Corner::*member, double sign, double bound) const;

private:
    static constexpr std::size_t corners_max = 8;  // a triangle cut by four half-planes has seven
    std::array<Corner, corners_max> corners_{};
    std::size_t size_ = 0;
};

/// A triangle and the slab of points within reach of its plane.
class Slab {
public:
    Slab(const Corners& corners, double reach_m);

    bool touches(const Cube& cube) const;
    /// The point may lie within reach of the triangle.
    bool holds(Vec3d point) const;
    /// The part of the other triangle that lies within the slab; may be larger. Empty where its depth_m() is at most
    /// `edge_band_m` - reach.
    WeightPolygon near_part(const Corners& other, double edge_band_m) const;
    /// How far inside the edge that they pass least the points come; negative beyond it.
    double depth_m(const WeightPolygon& points) const;
    /// Sets the bits (b1 * side + b2) of all cells within reach of the polygon; each cell is taken larger by
    /// `weight_slack` in every weight.
    void mark(const WeightPolygon& near, std::uint32_t side, double weight_slack, std::uint64_t* words) const;

    double inradius_m() const;
    double least_height_m() const;
    double double_area_m2() const { return double_area_m2_; }

private:
    NearBox near_;
    double reach_m_;
    double double_area_m2_;
    Vec3d corner_;
    Vec3d normal_;
    std::array<Vec3d, 3> slopes_;        ///< along which the weights grow [1/m]
    std::array<double, 3> steepness_{};  ///< their lengths: one over the heights of the triangle
};

}  // namespace lumenfarm
