#pragma once

#include "common/support/result.h"

#include <string>
#include <string_view>

/// What must hold of OBJ and MTL text before the library reads it: the library takes what is no number for 0.
/// Sentences name the line, not the file.
namespace lumenfarm::import {

/// `text` with continued lines joined. Errors: bad_input for v, vt and f lines whose numbers are missing, not finite or
/// not integers.
Result<std::string> checked_obj(std::string_view text);
/// Errors: bad_input for the statements of MTL that docs/scenes.md lists when their numbers are missing or not finite.
Result<std::string> checked_mtl(std::string_view text);

}  // namespace lumenfarm::import
