#pragma once

#include "common/scene/scene.h"
#include "common/transport/emission.h"
#include "common/transport/ray_query.h"

#include <array>
#include <cstdint>
#include <vector>

/// How a particle leaves its light: the first dimensions of law 2, from an Owen-scrambled Sobol point at its index.
namespace lumenfarm {

struct LaunchedParticle {
    Vec3d origin;
    Vec3d direction;  ///< unit
    std::uint32_t from_triangle = none;
    std::uint32_t wavelength = 0;  ///< bin
    std::uint32_t energy = 0;      ///< ticks
};

class Launcher {
public:
    /// REQUIRES: the arguments outlive this.
    Launcher(const Scene& scene, const Emission& emission, const std::vector<TriangleRecord>& triangles, std::uint64_t seed,
             std::uint32_t light);
    LaunchedParticle launch(std::uint32_t particle) const;

private:
    enum Dimension : std::uint32_t { area_u, area_v, angle_u, angle_v, wavelength, side };
    double coordinate(std::uint32_t particle, Dimension dimension) const;
    std::uint32_t wavelength_bin(double u) const;
    void leave_surface(std::uint32_t particle, LaunchedParticle& launched) const;

    const Scene* scene_;
    const Light* light_;
    const LightEmission* emission_;
    const std::vector<TriangleRecord>* triangles_;
    std::array<std::uint32_t, 6> scramble_;
    std::vector<std::uint16_t> bin_guide_;  ///< lowest bin that a u of [g, g + 1) / size can draw
};

}  // namespace lumenfarm
