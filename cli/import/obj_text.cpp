#include "cli/import/obj_text.h"

#include "common/support/limits.h"

#include <charconv>
#include <cmath>
#include <utility>

namespace lumenfarm::import {
namespace {

constexpr std::string_view blanks = " \t\r";

/// The next word of `line`, which loses it; empty at the end.
std::string_view take_word(std::string_view& line) {
    const std::size_t begin = line.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return line = {};
    const std::size_t end = std::min(line.find_first_of(blanks, begin), line.size());
    const std::string_view word = line.substr(begin, end - begin);
    line.remove_prefix(end);
    return word;
}

bool is_finite_number(std::string_view word) {
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return !word.empty() && error == std::errc{} && end == word.data() + word.size() && std::isfinite(value);
}

bool is_index(std::string_view word) {
    int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc{} && end == word.data() + word.size() && value != 0;
}

/// "1", "1/2", "1//3" or "1/2/3"; each a non-zero integer.
bool is_corner(std::string_view word) {
    const std::size_t first = word.find('/');
    if (!is_index(word.substr(0, first))) return false;
    if (first == std::string_view::npos) return true;
    word.remove_prefix(first + 1);
    const std::size_t second = word.find('/');
    if (second == std::string_view::npos) return is_index(word);
    return (second == 0 || is_index(word.substr(0, second))) && is_index(word.substr(second + 1));
}

Error refuse(std::size_t line, std::string_view what, const std::string& why) {
    return bad_input("line " + std::to_string(line) + ": " + std::string(what.substr(0, 80)) + " " + why);
}

Result<void> check_numbers(std::size_t line, std::string_view keyword, std::string_view rest, int least) {
    for (int i = 0; i < least; ++i) {
        const std::string_view word = take_word(rest);
        if (word.empty() || word.front() == '#')
            return refuse(line, keyword, "needs " + std::to_string(least) + " numbers");
        if (!is_finite_number(word))
            return refuse(line, keyword, "has '" + std::string(word.substr(0, 80)) + "', which is not a finite number");
    }
    return {};
}

Result<void> check_obj_line(std::size_t line, std::string_view text) {
    const std::string_view keyword = take_word(text);
    if (keyword == "v") return check_numbers(line, "the vertex", text, 3);
    if (keyword == "vt") return check_numbers(line, "the texture coordinate", text, 1);
    if (keyword != "f") return {};
    std::size_t corners = 0;
    for (std::string_view word = take_word(text); !word.empty() && word.front() != '#'; word = take_word(text)) {
        if (!is_corner(word))
            return refuse(line, "the face",
                          "has the corner '" + std::string(word.substr(0, 80)) +
                              "'; corners are v, v/vt, v//vn or v/vt/vn, counted from 1");
        ++corners;
    }
    if (corners < 3) return refuse(line, "the face", "has " + std::to_string(corners) + " corners; it needs 3");
    return {};
}

Result<void> check_mtl_line(std::size_t line, std::string_view text) {
    const std::string_view keyword = take_word(text);
    for (const std::string_view colour : {"Ka", "Kd", "Ks", "Ke", "Kt", "Tf"})
        if (keyword == colour) return check_numbers(line, keyword, text, 3);
    for (const std::string_view number : {"Ns", "Ni", "d", "Tr", "illum", "Pr", "Pm"})
        if (keyword == number) return check_numbers(line, keyword, text, 1);
    return {};
}

/// Joins continued lines and checks each. Comments and blanks at the end are cut, since the library reads them.
Result<std::string> check_lines(std::string_view text, Result<void> (*check)(std::size_t, std::string_view)) {
    std::string joined;
    joined.reserve(text.size());
    std::string line;
    std::size_t number = 0;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view piece = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        ++number;
        if (!piece.empty() && piece.back() == '\r') piece.remove_suffix(1);
        if (piece.find('\0') != std::string_view::npos) return refuse(number, "the text", "has a zero byte");
        if (!piece.empty() && piece.back() == '\\' && !text.empty()) {
            line.append(piece.substr(0, piece.size() - 1)).push_back(' ');
            continue;
        }
        line.append(piece);
        if (const std::size_t comment = line.find(" #"); comment != std::string::npos) line.resize(comment);
        line.erase(line.find_last_not_of(blanks) + 1);
        if (auto checked = check(number, line); !checked) return checked.error();
        joined.append(line).push_back('\n');
        line.clear();
    }
    return joined;
}

}  // namespace

Result<std::string> checked_obj(std::string_view text) { return check_lines(text, check_obj_line); }

Result<std::string> checked_mtl(std::string_view text) { return check_lines(text, check_mtl_line); }

}  // namespace lumenfarm::import
