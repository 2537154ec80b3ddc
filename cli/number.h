#pragma once

#include "common/math/vec.h"
#include "common/support/result.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Numbers as people type them.
namespace lumenfarm {

/// A whole number: 5000, 25e6, or 25M with a suffix k, M or G for thousands, millions, thousand millions; 1.5M too.
/// Plain digits go up to 2^64 - 1, the other forms to 2^53. Errors: bad_input.
Result<std::uint64_t> parse_count(std::string_view text);

/// Whole numbers with commas between: "1,2,4", each as parse_count(); at least one. Errors: bad_input.
Result<std::vector<std::uint64_t>> parse_counts(std::string_view text);

/// As parse_count() with a minus sign allowed, within 32 bits. Errors: bad_input.
Result<std::int32_t> parse_signed(std::string_view text);

/// A finite number, with the same suffixes. Errors: bad_input.
Result<double> parse_real(std::string_view text);

/// Three finite numbers with commas between: "1.5,0,-2". Errors: bad_input.
Result<Vec3d> parse_vector(std::string_view text);

struct CountRange {
    std::uint64_t first = 0;
    std::uint64_t last = 0;  ///< not before first
};
/// "A..B", both included, or "A" alone. Errors: bad_input.
Result<CountRange> parse_range(std::string_view text);

/// For people: 950, 12.3k, 1.21M, 4.00G.
std::string short_count(double count);

}  // namespace lumenfarm
