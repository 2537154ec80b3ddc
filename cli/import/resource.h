#pragma once

#include "common/support/result.h"

#include <filesystem>
#include <string>

namespace lumenfarm::import {

/// The path of a file that a scene file names. Only files in the scene's own folder or below are read: absolute names,
/// names with "..", and addresses ("http://...") are refused. Backslashes separate folders. Errors: bad_input.
Result<std::filesystem::path> resource_path(const std::filesystem::path& scene_file, const std::string& name);

}  // namespace lumenfarm::import
