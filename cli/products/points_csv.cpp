#include "cli/products/points_csv.h"

#include "common/support/limits.h"

#include <charconv>
#include <cmath>

namespace lumenfarm {
namespace {

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
    const auto begin = text.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::vector<std::string_view> fields_of(std::string_view line) {
    std::vector<std::string_view> fields;
    while (fields.size() < 8) {  // more than any row may have
        const auto comma = line.find(',');
        fields.push_back(trimmed(line.substr(0, comma)));
        if (comma == std::string_view::npos) break;
        line.remove_prefix(comma + 1);
    }
    return fields;
}

/// Foreign text for a sentence: short, and nothing that a terminal would obey.
std::string quoted(std::string_view text) {
    std::string quote = "'";
    for (const char c : text.substr(0, 40)) quote += c >= ' ' && c <= '~' ? c : '?';
    return quote + (text.size() > 40 ? "...'" : "'");
}

std::optional<double> number_of(std::string_view field) {
    if (field.starts_with('+')) field.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), number);
    if (error != std::errc{} || end != field.data() + field.size() || !std::isfinite(number)) return std::nullopt;
    return number;
}

Result<AskedPoint> parse_row(std::string_view line, const std::string& where) {
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.size() != 3 && fields.size() != 6)
        return bad_input(where + " has " + (fields.size() > 7 ? "more than 7" : std::to_string(fields.size())) +
                         " values; a row is x,y,z or x,y,z,nx,ny,nz");
    double values[6] = {};
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const auto number = number_of(fields[i]);
        if (!number) return bad_input(where + ": " + quoted(fields[i]) + " is not a number");
        if (std::abs(*number) > limits::coordinate_max_m)
            return bad_input(where + ": " + quoted(fields[i]) + " lies beyond the limit of coordinates");
        values[i] = *number;
    }
    AskedPoint point{{values[0], values[1], values[2]}, std::nullopt, 0};
    if (fields.size() == 3) return point;
    const Vec3d normal{values[3], values[4], values[5]};
    if (!(length(normal) > 1e-9)) return bad_input(where + ": the normal has no length");
    point.normal = normalize(normal);
    return point;
}

}  // namespace

Result<std::vector<AskedPoint>> parse_points(std::string_view text, const std::string& name) {
    std::vector<AskedPoint> points;
    bool head_allowed = true;
    for (std::uint64_t number = 1; !text.empty(); ++number) {
        const auto end = text.find('\n');
        const std::string_view line = trimmed(text.substr(0, end));
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        if (line.empty() || line.starts_with('#')) continue;
        const bool head = head_allowed && fields_of(line)[0] == "x";
        head_allowed = false;
        if (head) continue;
        if (points.size() == limits::points_max)
            return bad_input("'" + name + "' has more than " + std::to_string(limits::points_max) + " points");
        auto point = parse_row(line, "'" + name + "' line " + std::to_string(number));
        if (!point) return point.error();
        point->line = number;
        points.push_back(*point);
    }
    if (points.empty()) return bad_input("'" + name + "' holds no points");
    return points;
}

}  // namespace lumenfarm
