#include "common/scene/text.h"

#include "common/support/limits.h"

#include <cstdint>
#include <string_view>

namespace lumenfarm {
namespace {

/// Bytes of the well-formed character at the front of `text`, 0 when it is malformed or a control character.
/// [Unicode 15, table 3-7]
std::size_t character_bytes(std::string_view text) {
    const auto at = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const auto trail = [&](std::size_t i) { return at(i) >= 0x80 && at(i) <= 0xbf; };
    const unsigned first = at(0);
    if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
    if (first >= 0xc2 && first <= 0xdf) return trail(1) && !(first == 0xc2 && at(1) < 0xa0) ? 2 : 0;
    if (first >= 0xe0 && first <= 0xef) {
        const unsigned low = first == 0xe0 ? 0xa0 : 0x80;
        const unsigned high = first == 0xed ? 0x9f : 0xbf;
        return at(1) >= low && at(1) <= high && trail(2) ? 3 : 0;
    }
    if (first >= 0xf0 && first <= 0xf4) {
        const unsigned low = first == 0xf0 ? 0x90 : 0x80;
        const unsigned high = first == 0xf4 ? 0x8f : 0xbf;
        return at(1) >= low && at(1) <= high && trail(2) && trail(3) ? 4 : 0;
    }
    return 0;
}

}  // namespace

bool is_clean_name(const std::string& text) {
    if (text.size() > limits::name_bytes_max) return false;
    std::string_view rest = text;
    while (!rest.empty()) {
        const std::size_t bytes = character_bytes(rest);
        if (bytes == 0) return false;
        rest.remove_prefix(bytes);
    }
    return true;
}

std::string clean_name(const std::string& text) {
    std::string clean;
    std::string_view rest = text;
    while (!rest.empty()) {
        const std::size_t bytes = character_bytes(rest);
        const std::string_view character = bytes > 0 ? rest.substr(0, bytes) : std::string_view("?");
        if (clean.size() + character.size() > limits::name_bytes_max) break;
        clean += character;
        rest.remove_prefix(bytes > 0 ? bytes : 1);
    }
    return clean;
}

}  // namespace lumenfarm
