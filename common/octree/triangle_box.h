#pragma once

#include <smmintrin.h>

#include <array>
#include <bit>
#include <cstdint>

/// Which of the eight octants of a cube a triangle overlaps: separating axes [Akenine-Moller 2001], one-sided edge
/// tests in the three projections [Schwarz and Seidel 2010, sec. 3], for all octants at once. Plain SSE arithmetic: the
/// same bits on every machine.
namespace lumenfarm::octree_detail {

/// A cube: centre and half of its side; both, and the centres of its octants, are exact floats.
struct Cube {
    __m128 centre;  ///< x, y, z, unused
    float half;
};

/// Octants whose closed halves are touched: bits 0..2 "lower half in x, y, z is touched", bits 3..5 "upper".
constexpr std::array<std::uint8_t, 64> make_octants_of_halves() {
    std::array<std::uint8_t, 64> table{};
    for (unsigned halves = 0; halves < 64; ++halves)
        for (unsigned octant = 0; octant < 8; ++octant)
            if (((halves >> 3 & octant) | (halves & ~octant & 7)) == 7)
                table[halves] = static_cast<std::uint8_t>(table[halves] | 1u << octant);
    return table;
}
inline constexpr std::array<std::uint8_t, 64> octants_of_halves = make_octants_of_halves();

/// Quadrants (bit upper a + 2 upper b) of a projection to the octants above and below them.
constexpr std::array<std::uint8_t, 16> make_octants_of_quadrants(unsigned axis_a, unsigned axis_b) {
    std::array<std::uint8_t, 16> table{};
    for (unsigned quadrants = 0; quadrants < 16; ++quadrants)
        for (unsigned octant = 0; octant < 8; ++octant)
            if (quadrants >> ((octant >> axis_a & 1) + 2 * (octant >> axis_b & 1)) & 1)
                table[quadrants] = static_cast<std::uint8_t>(table[quadrants] | 1u << octant);
    return table;
}
inline constexpr std::array<std::uint8_t, 16> octants_of_xy = make_octants_of_quadrants(0, 1);
inline constexpr std::array<std::uint8_t, 16> octants_of_yz = make_octants_of_quadrants(1, 2);
inline constexpr std::array<std::uint8_t, 16> octants_of_zx = make_octants_of_quadrants(2, 0);

/// A bound on the rounding of an edge function, and of the plane's, over the second and third power of the largest
/// coordinate: 48 and 350 units of 2^-24 by counting operations, rounded up. It makes the test conservative.
inline constexpr float edge_rounding = 0x1p-18f;
inline constexpr float plane_rounding = 0x1p-14f;

inline __m128 absolute(__m128 v) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), v); }
inline __m128 next_corner(__m128 v) { return _mm_shuffle_ps(v, v, _MM_SHUFFLE(3, 0, 2, 1)); }

/// Quadrants of the a-b plane that the projected triangle overlaps by its edges. Lanes are corners and the edges that
/// start there; normal_c: the normal's component along a x b in lane 0; quarter: a quarter of the cube's side.
inline unsigned overlapped_quadrants(__m128 a, __m128 b, __m128 edge_a, __m128 edge_b, __m128 normal_c, __m128 quarter,
                                     __m128 margin) {
    const __m128 minus = _mm_set1_ps(-0.0f);
    const __m128 turn = _mm_and_ps(_mm_shuffle_ps(normal_c, normal_c, 0), minus);
    const __m128 inward_a = _mm_xor_ps(_mm_xor_ps(edge_b, turn), minus);
    const __m128 inward_b = _mm_xor_ps(edge_a, turn);
    const __m128 at_centre = _mm_sub_ps(margin, _mm_add_ps(_mm_mul_ps(inward_a, a), _mm_mul_ps(inward_b, b)));
    const __m128 step_a = _mm_mul_ps(inward_a, quarter);
    const __m128 step_b = _mm_mul_ps(inward_b, quarter);
    const __m128 highest = _mm_add_ps(at_centre, _mm_add_ps(absolute(step_a), absolute(step_b)));
    const __m128 lower = _mm_sub_ps(highest, step_a);
    const __m128 upper = _mm_add_ps(highest, step_a);
    const auto inside = [](__m128 value) { return (_mm_movemask_ps(value) & 7) == 0 ? 1u : 0u; };
    return inside(_mm_sub_ps(lower, step_b)) | inside(_mm_sub_ps(upper, step_b)) << 1 |
           inside(_mm_add_ps(lower, step_b)) << 2 | inside(_mm_add_ps(upper, step_b)) << 3;
}

/// Octants that the triangle's plane meets. corner: x, y, z of one; normal: in units of its own length.
inline unsigned octants_on_plane(__m128 corner, __m128 normal, __m128 quarter, __m128 margin) {
    const __m128 x = _mm_shuffle_ps(normal, normal, 0x00), y = _mm_shuffle_ps(normal, normal, 0x55),
                 z = _mm_shuffle_ps(normal, normal, 0xaa);
    const __m128 at_centre = _mm_xor_ps(_mm_dp_ps(corner, normal, 0x7f), _mm_set1_ps(-0.0f));
    const __m128 step_x = _mm_mul_ps(x, quarter), step_y = _mm_mul_ps(y, quarter), step_z = _mm_mul_ps(z, quarter);
    const __m128 reach =
        _mm_add_ps(margin, _mm_add_ps(absolute(step_x), _mm_add_ps(absolute(step_y), absolute(step_z))));
    const __m128 middle = _mm_add_ps(at_centre, _mm_add_ps(_mm_xor_ps(step_x, _mm_setr_ps(-0.0f, 0, -0.0f, 0)),
                                                           _mm_xor_ps(step_y, _mm_setr_ps(-0.0f, -0.0f, 0, 0))));
    const __m128 lower = _mm_cmple_ps(absolute(_mm_sub_ps(middle, step_z)), reach);
    const __m128 upper = _mm_cmple_ps(absolute(_mm_add_ps(middle, step_z)), reach);
    return static_cast<unsigned>(_mm_movemask_ps(lower) | _mm_movemask_ps(upper) << 4);
}

/// The separating axes that the bounding box leaves: the plane and the nine edge products. Corners relative to the
/// cube's centre; `size` is the largest magnitude among them in the lanes x, y, z.
inline unsigned octants_by_separating_axes(__m128 v0, __m128 v1, __m128 v2, __m128 size, float half) {
    __m128 x = v0, y = v1, z = v2, unused = _mm_setzero_ps();
    _MM_TRANSPOSE4_PS(x, y, z, unused);
    const __m128 edge_x = _mm_sub_ps(next_corner(x), x);
    const __m128 edge_y = _mm_sub_ps(next_corner(y), y);
    const __m128 edge_z = _mm_sub_ps(next_corner(z), z);
    const auto product = [](__m128 a, __m128 b) {
        return _mm_sub_ps(_mm_mul_ps(a, next_corner(b)), _mm_mul_ps(b, next_corner(a)));
    };
    const __m128 normal_x = product(edge_y, edge_z);
    const __m128 normal_y = product(edge_z, edge_x);
    const __m128 normal_z = product(edge_x, edge_y);

    __m128 largest = _mm_max_ps(size, _mm_shuffle_ps(size, size, _MM_SHUFFLE(3, 0, 2, 1)));
    largest = _mm_max_ps(largest, _mm_shuffle_ps(size, size, _MM_SHUFFLE(3, 1, 0, 2)));
    largest = _mm_add_ps(_mm_shuffle_ps(largest, largest, 0), _mm_set1_ps(half));
    const __m128 square = _mm_mul_ps(largest, largest);
    const __m128 edge_margin = _mm_mul_ps(square, _mm_set1_ps(edge_rounding));
    const __m128 plane_margin = _mm_mul_ps(_mm_mul_ps(square, largest), _mm_set1_ps(plane_rounding));
    const __m128 quarter = _mm_set1_ps(0.5f * half);

    const __m128 normal = _mm_movelh_ps(_mm_unpacklo_ps(normal_x, normal_y), normal_z);
    return octants_on_plane(v0, normal, quarter, plane_margin) &
           octants_of_xy[overlapped_quadrants(x, y, edge_x, edge_y, normal_z, quarter, edge_margin)] &
           octants_of_yz[overlapped_quadrants(y, z, edge_y, edge_z, normal_x, quarter, edge_margin)] &
           octants_of_zx[overlapped_quadrants(z, x, edge_z, edge_x, normal_y, quarter, edge_margin)];
}

/// Bit o: the triangle overlaps octant o of the cube, or comes nearer to it than rounding can tell. Never an octant
/// that its bounding box does not touch. `corners` are nine floats followed by a readable tenth. REQUIRES: the triangle
/// overlaps the cube.
inline unsigned overlapped_octants(const float* corners, const Cube& cube) {
    const __m128 v0 = _mm_sub_ps(_mm_loadu_ps(corners), cube.centre);
    const __m128 v1 = _mm_sub_ps(_mm_loadu_ps(corners + 3), cube.centre);
    const __m128 v2 = _mm_sub_ps(_mm_loadu_ps(corners + 6), cube.centre);
    const __m128 low = _mm_min_ps(_mm_min_ps(v0, v1), v2);
    const __m128 high = _mm_max_ps(_mm_max_ps(v0, v1), v2);
    const __m128 zero = _mm_setzero_ps();
    const auto lower = static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(low, zero)) & 7);
    const auto upper = static_cast<unsigned>(_mm_movemask_ps(_mm_cmpge_ps(high, zero)) & 7);
    const unsigned touched = octants_of_halves[lower | upper << 3];
    // One octant: what overlaps the cube can only be there.
    if (std::has_single_bit(touched)) return touched;
    // A triangle inside the cube that crosses one middle plane has a corner on either side.
    const __m128 size = _mm_max_ps(absolute(low), absolute(high));
    const bool inside = (_mm_movemask_ps(_mm_cmple_ps(size, _mm_set1_ps(cube.half))) & 7) == 7;
    if (inside && std::has_single_bit(lower & upper)) return touched;
    return touched & octants_by_separating_axes(v0, v1, v2, size, cube.half);
}

}  // namespace lumenfarm::octree_detail
