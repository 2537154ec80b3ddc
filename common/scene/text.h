#pragma once

#include <string>

/// Names that users see: in terminals, tables and JSON.
namespace lumenfarm {

/// True for valid UTF-8 of at most limits::name_bytes_max bytes without control characters.
bool is_clean_name(const std::string& text);

/// The nearest clean name: offending bytes become '?', what is too long is cut at a character's end.
std::string clean_name(const std::string& text);

}  // namespace lumenfarm
