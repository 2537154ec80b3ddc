#pragma once

#include "cli/import/scene_builder.h"

/// One reader a family of formats; each fills the builder from builder.file(). Errors: bad_input.
namespace lumenfarm::import {

Result<void> read_gltf(SceneBuilder& builder);
Result<void> read_obj(SceneBuilder& builder, const ImportOptions& options);
Result<void> read_by_assimp(SceneBuilder& builder, const ImportOptions& options);

/// True when Assimp has a reader for ".ext".
bool assimp_reads(const std::string& extension);

}  // namespace lumenfarm::import
