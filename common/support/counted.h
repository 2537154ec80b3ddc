#pragma once

#include <cstdint>
#include <string>

namespace lumenfarm {

/// For people: "no workers", "1 worker", "2 workers".
inline std::string counted(std::uint64_t count, const std::string& thing) {
    return (count == 0 ? "no" : std::to_string(count)) + " " + thing + (count == 1 ? "" : "s");
}

}  // namespace lumenfarm
