#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace lumenfarm {

/// What std::printf makes of it; at most 511 characters.
template <class... Values>
std::string format_line(const char* format, Values... values) {
    std::array<char, 512> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, values...);
    return buffer.data();
}

}  // namespace lumenfarm
