#pragma once

#include "cli/import/scene_builder.h"

namespace lumenfarm::import {

/// The light of `--light`: a D65 square "default light" of a quarter of the scene's footprint (in sides: a half), just
/// under the top (above a flat scene), that shines down. Its flux would give the footprint 500 lx without any
/// reflection. REQUIRES: the scene has triangles. Adds its material to `builder`.
MeshPart default_light(SceneBuilder& builder);

}  // namespace lumenfarm::import
