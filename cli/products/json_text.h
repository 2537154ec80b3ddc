#pragma once

#include <boost/json/value.hpp>

#include <string>

namespace lumenfarm {

/// JSON with two spaces of indentation and a line break at the end; numbers in the shortest form that reads back to the
/// same bits. NaN and infinity, which JSON does not know, become null.
std::string json_text(const boost::json::value& value);

}  // namespace lumenfarm
