#include "proto/text.h"

#include <algorithm>

namespace lumenfarm::wire {
namespace {

bool is_control(char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7f;
}

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

}  // namespace

std::string presentable(std::string_view text, std::size_t bytes_max) {
    auto size = std::min(text.size(), bytes_max);
    if (size < text.size())
        while (size > 0 && continues_character(text[size])) --size;
    std::string cut(text.substr(0, size));
    std::ranges::replace_if(cut, is_control, ' ');
    return cut;
}

bool is_presentable(std::string_view text) { return std::ranges::none_of(text, is_control); }

}  // namespace lumenfarm::wire
