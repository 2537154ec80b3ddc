#pragma once

#include "common/scene/scene.h"

#include <cstdint>
#include <random>

/// Small scenes for the tests of the octree: triangles only.
namespace lumenfarm::test {

inline void add_triangle(Scene& scene, Vec3f a, Vec3f b, Vec3f c) {
    const auto first = static_cast<std::uint32_t>(scene.positions.size());
    scene.positions.insert(scene.positions.end(), {a, b, c});
    scene.triangles.push_back({first, first + 1, first + 2});
}

/// Triangles of about `size` anywhere in a cube of `side` about `centre`.
inline Scene soup(std::uint32_t count, float side, float size, Vec3f centre, unsigned seed) {
    Scene scene;
    std::minstd_rand random(seed);
    const auto uniform = [&random] { return static_cast<float>(static_cast<double>(random()) / 2147483648.0 - 0.5); };
    const auto anywhere = [&](float s) {
        const float x = uniform(), y = uniform(), z = uniform();
        return Vec3f{x, y, z} * s;
    };
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3f at = centre + anywhere(side);
        const Vec3f a = at + anywhere(size), b = at + anywhere(size), c = at + anywhere(size);
        add_triangle(scene, a, b, c);
    }
    return scene;
}

/// A flat grid of side x side quads of 1 m in y = 0: every corner is shared by six triangles, many lie on cell bounds.
inline Scene floor_grid(std::uint32_t side) {
    Scene scene;
    for (std::uint32_t i = 0; i <= side; ++i)
        for (std::uint32_t j = 0; j <= side; ++j)
            scene.positions.push_back({static_cast<float>(i), 0, static_cast<float>(j)});
    for (std::uint32_t i = 0; i < side; ++i)
        for (std::uint32_t j = 0; j < side; ++j) {
            const std::uint32_t a = i * (side + 1) + j;
            scene.triangles.push_back({a, a + 1, a + side + 1});
            scene.triangles.push_back({a + 1, a + side + 2, a + side + 1});
        }
    return scene;
}

}  // namespace lumenfarm::test
