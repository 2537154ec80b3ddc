#pragma once

#include "common/scene/scene.h"
#include "common/support/result.h"

#include <cstdint>
#include <string>

namespace lumenfarm {

/// The light that is called `wanted`, or has that number. Errors: bad_input says which lights there are.
Result<std::uint32_t> choose_light(const Scene& scene, const std::string& wanted);

}  // namespace lumenfarm
