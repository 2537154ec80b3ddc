#pragma once

#include "common/transport/lanes.h"
#include "common/transport/triangle_test.h"

#include <emmintrin.h>

#include <cstddef>
#include <cstdint>

namespace lumenfarm {

/// A triangle in each lane. The functions do what their namesakes in triangle_test.h do.
class TriangleLanes {
public:
    /// By index; lanes without a triangle (none) hold another one.
    void gather(const TriangleRecord* triangles, const Lanes<std::uint32_t>& index);

    std::uint32_t surface(std::size_t lane) const { return surface_[lane]; }
    double per_double_area_m2(std::size_t lane) const { return per_double_area_m2_[lane]; }
    Vec3d corner(std::size_t lane, std::size_t c) const {
        return {static_cast<double>(x_[c][lane]), static_cast<double>(y_[c][lane]), static_cast<double>(z_[c][lane])};
    }
    Vec3d unit_normal(std::size_t lane) const {
        return double_area_normal(corner(lane, 0), corner(lane, 1), corner(lane, 2)) * per_double_area_m2_[lane];
    }
    Vec3d point(std::size_t lane, double b1, double b2) const {
        return point_on(corner(lane, 0), corner(lane, 1), corner(lane, 2), b1, b2);
    }

private:
    alignas(64) std::array<Lanes<float>, 3> x_, y_, z_;
    alignas(64) Lanes<std::uint32_t> surface_;
    alignas(64) Lanes<double> per_double_area_m2_;
};

inline void TriangleLanes::gather(const TriangleRecord* triangles, const Lanes<std::uint32_t>& index) {
    // four records at a time: quarters of their cache lines, transposed
    static_assert(offsetof(TriangleRecord, corners) == 0 && offsetof(TriangleRecord, surface) == 36 &&
                  offsetof(TriangleRecord, per_double_area_m2) == 40);
    for (std::size_t k = 0; k < lane_count; k += 4) {
        const float* record[4];
        for (std::size_t j = 0; j < 4; ++j)
            record[j] = reinterpret_cast<const float*>(&triangles[index[k + j] == none ? 0 : index[k + j]]);
        const auto quarter = [&](std::size_t j, std::size_t q) { return _mm_load_ps(record[j] + 4 * q); };
        const auto keep = [&](Lanes<float>& lanes, __m128 value) { _mm_store_ps(&lanes[k], value); };
        __m128 a0 = quarter(0, 0), a1 = quarter(1, 0), a2 = quarter(2, 0), a3 = quarter(3, 0);
        _MM_TRANSPOSE4_PS(a0, a1, a2, a3);
        keep(x_[0], a0);
        keep(y_[0], a1);
        keep(z_[0], a2);
        keep(x_[1], a3);
        __m128 b0 = quarter(0, 1), b1 = quarter(1, 1), b2 = quarter(2, 1), b3 = quarter(3, 1);
        _MM_TRANSPOSE4_PS(b0, b1, b2, b3);
        keep(y_[1], b0);
        keep(z_[1], b1);
        keep(x_[2], b2);
        keep(y_[2], b3);
        const __m128 c0 = quarter(0, 2), c1 = quarter(1, 2), c2 = quarter(2, 2), c3 = quarter(3, 2);
        const __m128 low = _mm_unpacklo_ps(c0, c1);
        const __m128 high = _mm_unpacklo_ps(c2, c3);
        keep(z_[2], _mm_movelh_ps(low, high));
        _mm_store_si128(reinterpret_cast<__m128i*>(&surface_[k]), _mm_castps_si128(_mm_movehl_ps(high, low)));
        _mm_store_pd(&per_double_area_m2_[k], _mm_unpackhi_pd(_mm_castps_pd(c0), _mm_castps_pd(c1)));
        _mm_store_pd(&per_double_area_m2_[k + 2], _mm_unpackhi_pd(_mm_castps_pd(c2), _mm_castps_pd(c3)));
    }
}

}  // namespace lumenfarm
