#pragma once

#include "common/math/vec.h"
#include "common/support/result.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lumenfarm {

/// A point where illuminance is asked for [m].
struct AskedPoint {
    Vec3d position;
    std::optional<Vec3d> normal;  ///< unit: the side that faces it is measured
    std::uint64_t line = 0;       ///< of the file, from 1
};

/// Rows x,y,z[,nx,ny,nz] in metres; blank lines, lines that begin with # and one head line whose first word is x are
/// passed over. `name` stands in the sentences. Errors: bad_input with the line and the value.
Result<std::vector<AskedPoint>> parse_points(std::string_view text, const std::string& name);

}  // namespace lumenfarm
