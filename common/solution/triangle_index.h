#pragma once

#include "common/math/vec.h"
#include "common/scene/scene.h"

#include <cstdint>
#include <vector>

/// Finds the triangles near a point: a hierarchy of boxes over a scene's triangles. Read-only once made.
namespace lumenfarm {

class TriangleIndex {
public:
    /// REQUIRES: `scene` outlives this.
    explicit TriangleIndex(const Scene& scene);

    /// Appends the triangles whose box meets the ball; an order that depends on the scene only.
    void near(Vec3d centre, double radius_m, std::vector<std::uint32_t>& triangles) const;

private:
    struct Node {
        Box box;
        std::uint32_t first = 0;  ///< leaf: into order_; inner: the right child, the left one follows the node
        std::uint32_t count = 0;  ///< 0 for an inner node
    };
    void build(std::uint32_t begin, std::uint32_t end, const std::vector<Box>& boxes);

    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
};

/// The point of a triangle that is nearest to `point`, with its barycentrics. [Ericson 2005, sec. 5.1.5]
struct NearestPoint {
    Vec3d point;
    double b1 = 0, b2 = 0;
    double distance = 0;
};
NearestPoint nearest_on_triangle(const Scene& scene, std::uint32_t triangle, Vec3d point);

}  // namespace lumenfarm
