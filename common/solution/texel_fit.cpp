#include "common/solution/texel_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace lumenfarm {
namespace {

constexpr std::size_t terms_max = 6;
using Terms = std::array<double, terms_max>;

std::size_t term_count(FitDegree degree) {
    return degree == FitDegree::constant ? 1 : degree == FitDegree::linear ? 3 : 6;
}

Terms terms_at(double u, double v) { return {1, u, v, u * u, u * v, v * v}; }

/// First column of the inverse of a symmetric positive matrix, by Cholesky; nothing when it is close to singular.
std::optional<Terms> first_column_of_inverse(const std::array<Terms, terms_max>& matrix, std::size_t n) {
    std::array<Terms, terms_max> lower{};
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = matrix[i][j];
            for (std::size_t k = 0; k < j; ++k) sum -= lower[i][k] * lower[j][k];
            if (i != j) {
                lower[i][j] = sum / lower[j][j];
                continue;
            }
            if (!(sum > 1e-3 * matrix[i][i])) return std::nullopt;
            lower[i][i] = std::sqrt(sum);
        }
    }
    Terms half{}, column{};
    for (std::size_t i = 0; i < n; ++i) {
        double sum = i == 0 ? 1 : 0;
        for (std::size_t k = 0; k < i; ++k) sum -= lower[i][k] * half[k];
        half[i] = sum / lower[i][i];
    }
    for (std::size_t i = n; i-- > 0;) {
        double sum = half[i];
        for (std::size_t k = i + 1; k < n; ++k) sum -= lower[k][i] * column[k];
        column[i] = sum / lower[i][i];
    }
    return column;
}

/// How the constant term of the fit follows from the moments. A constant fit always has one.
std::optional<Terms> solve(const std::array<Terms, terms_max>& moments, FitDegree degree, std::size_t samples) {
    const std::size_t terms = term_count(degree);
    if (degree != FitDegree::constant && samples < 2 * terms) return std::nullopt;
    return first_column_of_inverse(moments, terms);
}

FitDegree lower(FitDegree degree) { return degree == FitDegree::quadratic ? FitDegree::linear : FitDegree::constant; }

struct Tangents {
    explicit Tangents(Vec3d normal) {
        const Vec3d off = std::abs(normal.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
        u = normalize(cross(off, normal));
        v = cross(normal, u);
    }
    Vec3d u, v;
};

struct CellRange {
    std::uint32_t begin, end;
};

/// Rows (or columns) of an n x n grid that [low, high] in barycentrics may touch.
CellRange cell_range(double low, double high, std::uint32_t n) {
    const double first = std::clamp(std::floor(low * n) - 1, 0.0, static_cast<double>(n));
    const double last = std::clamp(std::floor(high * n) + 1, 0.0, static_cast<double>(n));
    return {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last)};
}

double longest_edge_m(const TriangleFrame& frame) {
    return std::max({length(frame.edge1), length(frame.edge2), length(frame.edge2 - frame.edge1)});
}

}  // namespace

TexelFit::TexelFit(const Scene& scene, const TriangleIndex& index, const TexelLayout& layout, const Solution& solution,
                   const TickValue& tick)
    : scene_(scene),
      index_(index),
      layout_(layout),
      solution_(solution),
      tick_(tick),
      texel_m_(texel_in_force_m(solution.spec, scene)) {}

double TexelFit::texel_m(const SurfacePoint& point) const {
    const TriangleFrame frame(scene_, point.triangle);
    return std::max(texel_m_, longest_edge_m(frame) / layout_.rows(point.triangle));
}

void TexelFit::gather(const SurfacePoint& point, double radius_m, std::vector<Sample>& samples) const {
    samples.clear();
    thread_local std::vector<std::uint32_t> triangles;
    triangles.clear();
    index_.near(point.position, radius_m, triangles);
    for (const std::uint32_t triangle : triangles) gather_triangle(point, triangle, radius_m, samples);
}

void TexelFit::gather_triangle(const SurfacePoint& point, std::uint32_t triangle, double radius_m,
                               std::vector<Sample>& samples) const {
    const double distance = nearest_on_triangle(scene_, triangle, point.position).distance;
    if (distance > radius_m) return;
    const TriangleFrame frame(scene_, triangle);
    const auto side = continuing_side(point, frame, distance);
    if (!side) return;
    // b1 and b2 of the foot of the point, and how fast they change within the plane
    const double twice = 2 * frame.area_m2;
    const Vec3d slope1 = cross(frame.edge2, frame.normal) * (1 / twice);
    const Vec3d slope2 = cross(frame.normal, frame.edge1) * (1 / twice);
    const Vec3d from_corner = point.position - frame.corner;
    const double b1 = dot(from_corner, slope1), b2 = dot(from_corner, slope2);
    const double reach1 = radius_m * length(slope1), reach2 = radius_m * length(slope2);

    const std::uint32_t n = layout_.rows(triangle);
    const std::uint64_t first = layout_.first_texel(triangle, *side);
    const double texel_area = frame.area_m2 / (static_cast<double>(n) * n);
    const Tangents tangents(point.normal);
    const CellRange rows = cell_range(b1 - reach1, b1 + reach1, n);
    const CellRange columns = cell_range(b2 - reach2, b2 + reach2, n);
    for (std::uint32_t row = rows.begin; row < rows.end; ++row) {
        const std::uint32_t row_cell = n * n - (n - row) * (n - row);
        const std::uint32_t in_row_end = std::min(2 * columns.end, 2 * (n - row) - 1);
        for (std::uint32_t in_row = 2 * columns.begin; in_row < in_row_end; ++in_row) {
            const double shift = in_row % 2 == 1 ? 2.0 / 3 : 1.0 / 3;
            const Vec3d off =
                frame.edge1 * ((row + shift) / n) + frame.edge2 * ((in_row / 2 + shift) / n) - from_corner;
            const double nearness = 1 - dot(off, off) / (radius_m * radius_m);
            if (nearness <= 0) continue;
            samples.push_back({dot(off, tangents.u) / radius_m, dot(off, tangents.v) / radius_m,
                               nearness * nearness * texel_area, texel_area, first + row_cell + in_row});
        }
    }
}

PointEstimate TexelFit::combine(const std::vector<Sample>& samples, const std::vector<double>& shares,
                                double radius_m) const {
    PointEstimate estimate;
    double variance = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const TexelEstimate texel = texel_estimate(solution_.texels[samples[i].texel], samples[i].area_m2, tick_);
        estimate.xyz_lx = estimate.xyz_lx + texel.xyz_lx * shares[i];
        estimate.irradiance_w_m2 += texel.irradiance_w_m2 * shares[i];
        variance += texel.variance_lx2 * shares[i] * shares[i];
        estimate.hits += texel.hits;
    }
    estimate.standard_error_lx = estimate.hits > 0 ? std::sqrt(variance) : std::numeric_limits<double>::quiet_NaN();
    estimate.radius_m = radius_m;
    return estimate;
}

PointEstimate TexelFit::at(const SurfacePoint& point, double radius_m, FitDegree degree) const {
    thread_local std::vector<Sample> samples;
    thread_local std::vector<double> shares;
    for (gather(point, radius_m, samples); samples.empty(); gather(point, radius_m, samples)) radius_m *= 2;

    std::array<Terms, terms_max> moments{};
    for (const Sample& sample : samples) {
        const Terms terms = terms_at(sample.u, sample.v);
        for (std::size_t i = 0; i < term_count(degree); ++i)
            for (std::size_t j = 0; j <= i; ++j) moments[i][j] += sample.weight * terms[i] * terms[j];
    }
    std::optional<Terms> solved = solve(moments, degree, samples.size());
    while (!solved) solved = solve(moments, degree = lower(degree), samples.size());
    shares.clear();
    for (const Sample& sample : samples) {
        const Terms terms = terms_at(sample.u, sample.v);
        double share = 0;
        for (std::size_t i = 0; i < term_count(degree); ++i) share += (*solved)[i] * terms[i];
        shares.push_back(share * sample.weight);
    }
    return combine(samples, shares, radius_m);
}

double TexelFit::hits_per_m2(const SurfacePoint& point, double radius_m) const {
    thread_local std::vector<Sample> samples;
    gather(point, radius_m, samples);
    double hits = 0, weights = 0;
    for (const Sample& sample : samples) {
        hits += static_cast<double>(solution_.texels[sample.texel].hits) * sample.weight / sample.area_m2;
        weights += sample.weight;
    }
    return weights > 0 ? hits / weights : 0;
}

}  // namespace lumenfarm
