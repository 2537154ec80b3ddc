#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// Texts on the wire are shown to people: on a terminal, in a log, in a browser.
namespace lumenfarm::wire {

/// The text as it travels: control characters become spaces, and what is longer than `bytes_max` is cut before the
/// character (UTF-8) that does not fit.
std::string presentable(std::string_view text, std::size_t bytes_max);

/// False when a byte is a control character.
bool is_presentable(std::string_view text);

}  // namespace lumenfarm::wire
