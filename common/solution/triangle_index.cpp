#include "common/solution/triangle_index.h"

#include <algorithm>
#include <numeric>

namespace lumenfarm {
namespace {

constexpr std::uint32_t leaf_triangles = 4;

Box box_of(const Scene& scene, std::uint32_t triangle) {
    Box box;
    for (const std::uint32_t corner : scene.triangles[triangle]) {
        const Vec3d p = scene.positions[corner].as<double>();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min(box.low[axis], p[axis]);
            box.high[axis] = std::max(box.high[axis], p[axis]);
        }
    }
    return box;
}

void grow(Box& box, const Box& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::min(box.low[axis], other.low[axis]);
        box.high[axis] = std::max(box.high[axis], other.high[axis]);
    }
}

std::size_t longest_axis(const Box& box) {
    const Vec3d size = box.high - box.low;
    if (size.x >= size.y && size.x >= size.z) return 0;
    return size.y >= size.z ? 1 : 2;
}

double distance_squared(const Box& box, Vec3d p) {
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double off = std::max({box.low[axis] - p[axis], 0.0, p[axis] - box.high[axis]});
        sum += off * off;
    }
    return sum;
}

}  // namespace

TriangleIndex::TriangleIndex(const Scene& scene) : order_(scene.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<Box> boxes(order_.size());
    for (std::uint32_t i = 0; i < boxes.size(); ++i) boxes[i] = box_of(scene, i);
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()), boxes);
}

void TriangleIndex::build(std::uint32_t begin, std::uint32_t end, const std::vector<Box>& boxes) {
    const auto at = nodes_.size();
    nodes_.emplace_back();
    Box box, centres;
    for (std::uint32_t i = begin; i < end; ++i) {
        const Box& one = boxes[order_[i]];
        grow(box, one);
        const Vec3d centre = one.low + one.high;
        grow(centres, {centre, centre});
    }
    nodes_[at].box = box;
    if (end - begin <= leaf_triangles) {
        nodes_[at].first = begin;
        nodes_[at].count = end - begin;
        return;
    }
    const std::size_t axis = longest_axis(centres);
    const std::uint32_t middle = begin + (end - begin) / 2;
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        const double ca = boxes[a].low[axis] + boxes[a].high[axis];
        const double cb = boxes[b].low[axis] + boxes[b].high[axis];
        return ca != cb ? ca < cb : a < b;
    };
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, before);
    build(begin, middle, boxes);
    nodes_[at].first = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end, boxes);
}

void TriangleIndex::near(Vec3d centre, double radius_m, std::vector<std::uint32_t>& triangles) const {
    if (nodes_.empty()) return;
    const double reach = radius_m * radius_m;
    std::uint32_t stack[64];  // halving 2^32 triangles goes 32 deep
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const std::uint32_t at = stack[--depth];
        const Node& node = nodes_[at];
        if (distance_squared(node.box, centre) > reach) continue;
        if (node.count > 0) {
            for (std::uint32_t i = 0; i < node.count; ++i) triangles.push_back(order_[node.first + i]);
            continue;
        }
        stack[depth++] = node.first;
        stack[depth++] = at + 1;
    }
}

NearestPoint nearest_on_triangle(const Scene& scene, std::uint32_t triangle, Vec3d point) {
    const Triangle& corners = scene.triangles[triangle];
    const Vec3d a = scene.positions[corners[0]].as<double>();
    const Vec3d ab = scene.positions[corners[1]].as<double>() - a;
    const Vec3d ac = scene.positions[corners[2]].as<double>() - a;
    const auto at = [&](double b1, double b2) {
        const Vec3d p = a + ab * b1 + ac * b2;
        return NearestPoint{p, b1, b2, length(point - p)};
    };
    const Vec3d ap = point - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return at(0, 0);
    const Vec3d bp = ap - ab;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return at(1, 0);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return at(d1 / (d1 - d3), 0);
    const Vec3d cp = ap - ac;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return at(0, 1);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return at(0, d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return at(1 - w, w);
    }
    const double all = va + vb + vc;
    return at(vb / all, vc / all);
}

}  // namespace lumenfarm
