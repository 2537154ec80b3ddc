#pragma once

#include "common/math/vec.h"

#include <cmath>
#include <numbers>

/// Directions by chance. Only + - * / and sqrt, which IEEE 754 fixes: the same bits on every machine (law 9).
namespace lumenfarm {

template <class T>
struct SinCos {
    T sin, cos;
};

/// sin and cos of 2 pi turns, within 1e-11 (float: 2e-7). REQUIRES: 0 <= turns <= 1. No branches: the quadrant of a
/// random angle would be mispredicted half of the time.
template <class T>
SinCos<T> sin_cos_turns(T turns) {
    // reduce to an eighth of a turn either side of a multiple of a quarter: exact, as 4 * turns - q is
    const T quarters = 4 * turns;
    const auto quadrant = static_cast<int>(quarters + T(0.5));
    const T x = (quarters - static_cast<T>(quadrant)) * T(std::numbers::pi / 2);
    // Taylor series, odd and even powers of x^2 side by side; at pi/4 the first term left out is below 1e-11
    const T x2 = x * x;
    const T x4 = x2 * x2;
    const T s_odd = T(-1.0 / 6) + x4 * (T(-1.0 / 5040) + x4 * T(-1.0 / 39916800));
    const T s_even = 1 + x4 * (T(1.0 / 120) + x4 * T(1.0 / 362880));
    const T c_odd = T(-1.0 / 2) + x4 * (T(-1.0 / 720) + x4 * T(-1.0 / 3628800));
    const T c_even = 1 + x4 * (T(1.0 / 24) + x4 * (T(1.0 / 40320) + x4 * T(1.0 / 479001600)));
    const T s = x * (s_even + x2 * s_odd);
    const T c = c_even + x2 * c_odd;
    const bool odd = (quadrant & 1) != 0;
    const T sine = odd ? c : s;
    const T cosine = odd ? s : c;
    return {(quadrant & 2) != 0 ? -sine : sine, ((quadrant + 1) & 2) != 0 ? -cosine : cosine};
}

/// A right-handed orthonormal frame about a unit normal [Duff et al. 2017].
template <class T>
struct Frame {
    Vec3<T> tangent, bitangent, normal;
    Vec3<T> to_world(Vec3<T> local) const { return tangent * local.x + bitangent * local.y + normal * local.z; }
};

template <class T>
Frame<T> frame_about(Vec3<T> n) {
    const T sign = n.z < 0 ? T(-1) : T(1);
    const T a = -1 / (sign + n.z);
    const T b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

/// About +z, density cos(theta) / pi. REQUIRES: u, v in (0, 1).
template <class T>
Vec3<T> sample_cosine_hemisphere(T u, T v) {
    const SinCos<T> phi = sin_cos_turns(v);
    const T r = std::sqrt(u);
    return {r * phi.cos, r * phi.sin, std::sqrt(1 - u)};
}
/// The same about a unit normal. Chance needs no more than float, whose vector registers hold twice as many; the
/// result is unit in double (within 1e-12). REQUIRES: u, v in (0, 1), at most 1 - 2^-24.
inline Vec3d sample_cosine_about(Vec3d normal, float u, float v) {
    const auto near = frame_about(normal.as<float>()).to_world(sample_cosine_hemisphere(u, v)).as<double>();
    return near * (1.5 - 0.5 * dot(near, near));  // a step of Newton's method towards length 1
}
inline double pdf_cosine_hemisphere(Vec3d local) { return local.z > 0 ? local.z / std::numbers::pi : 0; }

/// About +z, uniform over directions with cos(theta) in [cos_low, cos_high] (a sphere: -1, 1).
inline Vec3d sample_uniform_zone(double u, double v, double cos_low, double cos_high) {
    const double z = cos_low + u * (cos_high - cos_low);
    const double sine2 = 1 - z * z;
    const double r = std::sqrt(sine2 > 0 ? sine2 : 0);
    const SinCos<double> phi = sin_cos_turns(v);
    return {r * phi.cos, r * phi.sin, z};
}
inline double pdf_uniform_zone(Vec3d local, double cos_low, double cos_high) {
    return local.z >= cos_low && local.z <= cos_high ? 1 / (2 * std::numbers::pi * (cos_high - cos_low)) : 0;
}

/// About +z, density in proportion to 1 for cos(theta) >= cos_inner and to x^2, x = (cos - cos_outer) / (cos_inner -
/// cos_outer), down to cos_outer: the spot of KHR_lights_punctual. x is the largest of three uniforms, whose
/// distribution is x^3. REQUIRES: u, v, w1, w2 in (0, 1).
inline Vec3d sample_spot(double u, double v, double w1, double w2, double cos_inner, double cos_outer) {
    const double inner = 1 - cos_inner;
    const double edge = (cos_inner - cos_outer) / 3;
    const double inner_share = inner / (inner + edge);
    if (u < inner_share) return sample_uniform_zone(u / inner_share, v, cos_inner, 1);
    const double stretched = (u - inner_share) / (1 - inner_share);
    const double x = stretched > w1 ? (stretched > w2 ? stretched : w2) : (w1 > w2 ? w1 : w2);
    const double cosine = cos_outer + x * (cos_inner - cos_outer);
    return sample_uniform_zone(0, v, cosine, 1);
}
inline double pdf_spot(Vec3d local, double cos_inner, double cos_outer) {
    if (local.z < cos_outer) return 0;
    const double solid_angle = 2 * std::numbers::pi * ((1 - cos_inner) + (cos_inner - cos_outer) / 3);
    if (local.z >= cos_inner) return 1 / solid_angle;
    const double x = (local.z - cos_outer) / (cos_inner - cos_outer);
    return x * x / solid_angle;
}

/// Barycentric weights (of the second and third corner), uniform over a triangle.
struct Barycentrics {
    double b1, b2;
};
inline Barycentrics sample_triangle(double u, double v) {
    const double root = std::sqrt(u);
    return {root * (1 - v), root * v};
}

}  // namespace lumenfarm
