#pragma once

#include "common/support/result.h"

#include <cstddef>
#include <span>
#include <string_view>

/// What must hold of a glTF file's bytes before a library may see them: the parser recurses, allocates for each value,
/// and trusts the lengths of a GLB. Sentences do not name the file.
namespace lumenfarm::import {

/// Errors: bad_input when brackets nest deeper than limits::json_depth_max or there are more than
/// limits::json_values_max values.
Result<void> check_json_shape(std::string_view json);

/// The JSON chunk of a GLB whose header and chunks fit in its bytes. Errors: bad_input.
Result<std::string_view> glb_json(std::span<const std::byte> bytes);

}  // namespace lumenfarm::import
