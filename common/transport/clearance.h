#pragma once

#include "common/scene/scene.h"

#include <cstdint>
#include <limits>
#include <vector>

/// Which parts of triangles have no other triangle near them, and do not lie near an edge. There a meeting that Embree
/// reports is the nearest one for certain, and a ray that starts there meets nothing at once (docs/physics.md).
namespace lumenfarm {

/// Of one triangle: a grid of cells over its barycentric weights b1, b2. Default: clear nowhere.
struct Clearance {
    float least_weight = std::numeric_limits<float>::infinity();  ///< clear points have three larger weights
    std::uint32_t cells_per_side = 1;
    std::uint32_t first_word = 0;  ///< in ClearanceMap::words; bit b1 * cells_per_side + b2
};

struct ClearanceRules {
    double reach_m = 0;        ///< what counts as near another triangle
    double edge_band_m = 0;    ///< what counts as near an edge; at least reach_m
    double enlargement_m = 0;  ///< weights of the triangle whose edges lie this much farther out may be asked for, too
};

class ClearanceMap {
public:
    ClearanceMap() = default;  ///< clear nowhere
    /// Conservative: what is called clear is clear, other points may be. Slivers, tiny triangles and
    /// those among very many neighbours are clear nowhere.
    /// REQUIRES: validate(scene) succeeds.
    static ClearanceMap make(const Scene& scene, const ClearanceRules& rules);

    const std::vector<Clearance>& triangles() const { return triangles_; }
    /// No triangle is near the light's position. False for surface lights.
    bool is_clear_at_light(std::uint32_t light) const { return light < lights_.size() && lights_[light]; }

    /// REQUIRES: finite weights; `clearance` is one of triangles().
    template <class T>
    bool is_clear(const Clearance& clearance, T b1, T b2) const {
        const T b0 = 1 - b1 - b2;
        const T least = b1 < b2 ? (b1 < b0 ? b1 : b0) : (b2 < b0 ? b2 : b0);
        if (!(least > static_cast<T>(clearance.least_weight))) return false;
        const auto side = static_cast<T>(clearance.cells_per_side);
        const std::uint32_t bit =
            static_cast<std::uint32_t>(static_cast<std::int32_t>(b1 * side)) * clearance.cells_per_side +
            static_cast<std::uint32_t>(static_cast<std::int32_t>(b2 * side));
        return words_[clearance.first_word + bit / 64] >> (bit & 63) & 1u;
    }

private:
    std::vector<Clearance> triangles_;
    std::vector<std::uint64_t> words_{~std::uint64_t{0}};  ///< the first serves all triangles that are clear throughout
    std::vector<bool> lights_;
};

}  // namespace lumenfarm
