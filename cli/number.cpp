#include "cli/number.h"

#include "common/scene/text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

namespace lumenfarm {
namespace {

constexpr double exact_double_max = 9'007'199'254'740'992;  // 2^53
constexpr std::size_t shown_bytes_max = 40;

struct Suffix {
    char letter;
    double factor;
};
constexpr std::array<Suffix, 3> suffixes{{{'k', 1e3}, {'M', 1e6}, {'G', 1e9}}};

std::string quoted(std::string_view text) {
    return "'" + clean_name(std::string(text.substr(0, shown_bytes_max))) + "'";
}

/// Takes the suffix off the text; 1 without one.
double take_suffix(std::string_view& text) {
    for (const auto& suffix : suffixes)
        if (!text.empty() && text.back() == suffix.letter) {
            text.remove_suffix(1);
            return suffix.factor;
        }
    return 1;
}

std::optional<double> read_real(std::string_view text) {
    const double factor = take_suffix(text);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) return {};
    number *= factor;
    if (!std::isfinite(number)) return {};
    return number;
}

}  // namespace

Result<std::uint64_t> parse_count(std::string_view text) {
    std::uint64_t digits = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), digits);
    if (error == std::errc() && end == text.data() + text.size()) return digits;
    const auto number = read_real(text);
    if (!number || *number < 0 || *number != std::floor(*number) || *number > exact_double_max)
        return bad_input(quoted(text) + " is not a whole number such as 5000, 25e6 or 25M");
    return static_cast<std::uint64_t>(*number);
}

Result<std::vector<std::uint64_t>> parse_counts(std::string_view text) {
    std::vector<std::uint64_t> counts;
    for (std::string_view rest = text;;) {
        const auto comma = rest.find(',');
        const auto count = parse_count(rest.substr(0, comma));
        if (!count) return bad_input(quoted(text) + " is not whole numbers with commas between, such as 1,2,4");
        counts.push_back(*count);
        if (comma == std::string_view::npos) return counts;
        rest.remove_prefix(comma + 1);
    }
}

Result<std::int32_t> parse_signed(std::string_view text) {
    const bool negative = !text.empty() && text.front() == '-';
    const auto size = parse_count(negative ? text.substr(1) : text);
    if (!size || *size > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
        return bad_input(quoted(text) + " is not a whole number such as 10 or -10");
    const auto number = static_cast<std::int32_t>(*size);
    return negative ? -number : number;
}

Result<double> parse_real(std::string_view text) {
    const auto number = read_real(text);
    if (!number) return bad_input(quoted(text) + " is not a number");
    return *number;
}

Result<Vec3d> parse_vector(std::string_view text) {
    const auto refuse = [&] { return bad_input(quoted(text) + " is not three numbers x,y,z"); };
    std::array<double, 3> xyz{};
    std::string_view rest = text;
    for (std::size_t axis = 0; axis < xyz.size(); ++axis) {
        const auto comma = rest.find(',');
        if ((comma == std::string_view::npos) != (axis + 1 == xyz.size())) return refuse();
        const auto number = read_real(rest.substr(0, comma));
        if (!number) return refuse();
        xyz[axis] = *number;
        if (comma != std::string_view::npos) rest.remove_prefix(comma + 1);
    }
    return Vec3d{xyz[0], xyz[1], xyz[2]};
}

Result<CountRange> parse_range(std::string_view text) {
    const auto dots = text.find("..");
    const auto first = parse_count(text.substr(0, dots));
    const auto last = dots == std::string_view::npos ? first : parse_count(text.substr(dots + 2));
    if (!first || !last) return bad_input(quoted(text) + " is not a range A..B of whole numbers");
    if (*last < *first) return bad_input(quoted(text) + " ends before it begins");
    return CountRange{*first, *last};
}

std::string short_count(double count) {
    std::array<char, 32> buffer{};
    const auto print = [&](const char* format, double value) {
        std::snprintf(buffer.data(), buffer.size(), format, value);
        return std::string(buffer.data());
    };
    if (!(count >= 999.5)) return print("%.0f", count);
    // what would be rounded up to 1000 belongs to the next suffix
    for (auto suffix = suffixes.rbegin(); suffix != suffixes.rend(); ++suffix)
        if (count >= 0.9995 * suffix->factor) return print("%.3g", count / suffix->factor) + suffix->letter;
    return print("%.0f", count);
}

}  // namespace lumenfarm
