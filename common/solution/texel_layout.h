#pragma once

#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/support/limits.h"
#include "common/support/result.h"
#include "common/transport/hit.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

/// The light map: each triangle carries an n x n barycentric grid of n^2 texels of equal area A / n^2, for each side.
namespace lumenfarm {

class TexelLayout {
public:
    /// n = ceil(longest edge / texel_m), at most limits::texel_rows_max. Errors: bad_input when the scene would have
    /// more than limits::texels_max texels: the sentence names a texel size that fits.
    static Result<TexelLayout> make(const Scene& scene, double texel_m);
    /// The layout with so many rows for each triangle, of so many surfaces. Errors: bad_input (too many texels).
    static Result<TexelLayout> of_rows(const std::vector<std::uint16_t>& rows,
                                       const std::vector<std::uint32_t>& surface_of_triangle, std::size_t surfaces);
    /// The layout of a job: the texel size in force for the spec and the scene's bounding box.
    static Result<TexelLayout> make(const Scene& scene, const JobSpec& spec);

    std::uint64_t texel_count() const { return triangles_.back().first_texel; }  ///< both sides together
    std::uint32_t rows(std::uint32_t triangle) const { return triangles_[triangle].rows; }
    std::vector<std::uint16_t> rows() const;  ///< of each triangle
    std::size_t surfaces() const { return surfaces_; }
    std::uint32_t surface_of(std::uint32_t triangle) const { return triangles_[triangle].surface; }
    /// First texel of a triangle's side; its n^2 texels follow.
    std::uint64_t first_texel(std::uint32_t triangle, std::uint32_t side) const {
        const Triangle of = triangles_[triangle];
        return of.first_texel + side * std::uint64_t{of.rows} * of.rows;
    }
    /// The texel of a packed hit; a pure function of the record.
    std::uint64_t texel_of(const HitRecord& hit) const {
        return first_texel(hit.triangle, hit.side()) + cell_of(hit.b1, hit.b2, rows(hit.triangle));
    }
    /// Asks for what is known of the triangle. (The compiler would drop calls of it as useless.)
    [[gnu::always_inline]] void prefetch(std::uint32_t triangle) const { __builtin_prefetch(&triangles_[triangle]); }
    /// Cell in [0, n^2) of packed barycentrics, taken at the middle of their step: row i = floor(b1 n), then the pair
    /// of sub-triangles of column j = floor(b2 n): lower 2j, upper 2j + 1; row i has 2 (n - i) - 1 cells. REQUIRES: b1,
    /// b2 < 65536; 0 < n <= limits::texel_rows_max.
    static std::uint32_t cell_of(std::uint32_t b1, std::uint32_t b2, std::uint32_t n);
    /// Rows are counted from the wide end: row i holds 2 (n - i) - 1 cells, so (n - i)^2 cells remain where it begins.
    static std::uint32_t first_cell_of_row(std::uint32_t row, std::uint32_t n) { return n * n - (n - row) * (n - row); }
    /// Barycentrics (b1, b2) of the centroid of a cell.
    static Vec2f cell_centroid(std::uint32_t cell, std::uint32_t n);
    /// Whether the cell is an upper one: it is turned about its middle.
    static bool is_upper(std::uint32_t cell, std::uint32_t n);
    /// Triangle and side of a texel, by binary search.
    struct Place {
        std::uint32_t triangle, side, cell;
    };
    Place place_of(std::uint64_t texel) const;

private:
    /// In 8 bytes: most of what adding a hit waits for is memory.
    struct Triangle {
        std::uint32_t first_texel = 0;
        std::uint32_t rows : 11 = 0;
        std::uint32_t surface : 21 = 0;
    };
    static_assert(sizeof(Triangle) == 8 && limits::texels_max < std::uint64_t{1} << 32 &&
                  limits::texel_rows_max < 1u << 11 && limits::surfaces_max < 1u << 21);

    std::vector<Triangle> triangles_;  ///< and behind them the number of texels
    std::size_t surfaces_ = 0;
};

inline std::uint32_t TexelLayout::cell_of(std::uint32_t b1, std::uint32_t b2, std::uint32_t n) {
    constexpr std::uint32_t one = 1u << 17;  // barycentrics in halves of a packed step, so that centres are integers
    const std::uint32_t u = (2 * b1 + 1) * n;
    const std::uint32_t v = (2 * b2 + 1) * n;
    const std::uint32_t row = u / one;
    const std::uint32_t across = u % one + v % one;
    // A centre that lies on the diagonal belongs to both cells: parity shares such points evenly.
    const bool upper = across > one || (across == one && (b1 & 1u) != 0);
    const std::uint32_t in_row = 2 * (v / one) + (upper ? 1 : 0);
    return first_cell_of_row(row, n) + std::min(in_row, 2 * (n - row) - 2);
}

/// texel_in_force_m() with the diagonal of the scene's bounding box.
double texel_in_force_m(const JobSpec& spec, const Scene& scene);

}  // namespace lumenfarm
