#pragma once

#include <cmath>
#include <cstddef>

/// Three-component vectors in the precision of the caller; no operation here depends on the instruction set.
namespace lumenfarm {

template <class T>
struct Vec3 {
    T x{}, y{}, z{};

    constexpr T operator[](std::size_t axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
    constexpr T& operator[](std::size_t axis) { return axis == 0 ? x : axis == 1 ? y : z; }
    constexpr bool operator==(const Vec3&) const = default;
    template <class U>
    constexpr Vec3<U> as() const {
        return {static_cast<U>(x), static_cast<U>(y), static_cast<U>(z)};
    }
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

struct Vec2f {
    float x = 0, y = 0;
    constexpr bool operator==(const Vec2f&) const = default;
};

template <class T>
constexpr Vec3<T> operator+(Vec3<T> a, Vec3<T> b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
constexpr Vec3<T> operator-(Vec3<T> a, Vec3<T> b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
constexpr Vec3<T> operator-(Vec3<T> a) {
    return {-a.x, -a.y, -a.z};
}
template <class T>
constexpr Vec3<T> operator*(Vec3<T> a, T s) {
    return {a.x * s, a.y * s, a.z * s};
}
template <class T>
constexpr Vec3<T> operator*(T s, Vec3<T> a) {
    return a * s;
}
template <class T>
constexpr T dot(Vec3<T> a, Vec3<T> b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// cross(a, b) == -cross(b, a) to the bit: each component is a difference of two commutative products.
template <class T>
constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T length(Vec3<T> a) {
    return std::sqrt(dot(a, a));
}
/// REQUIRES: length(a) > 0.
template <class T>
Vec3<T> normalize(Vec3<T> a) {
    return a * (T{1} / length(a));
}

}  // namespace lumenfarm
