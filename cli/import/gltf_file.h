#pragma once

#include "cli/import/scene_builder.h"

#include <tiny_gltf.h>

#include <cstddef>
#include <span>
#include <string>

/// A glTF file in memory, its buffers and pictures read, and checked where the library does not check.
namespace lumenfarm::import {

/// Pictures are kept as they are in the file (Image::image); one that is missing stays empty.
/// Errors: bad_input: unreadable, damaged, a required extension that is not supported, files outside the folder.
Result<tinygltf::Model> load_gltf(SceneBuilder& builder);

/// The bytes of a buffer view. Errors: bad_input when it lies outside its buffer.
Result<std::span<const std::byte>> view_bytes(const tinygltf::Model& model, int view, const SceneBuilder& builder);

/// "mesh 3" or "mesh 3 ('box')"
std::string gltf_name(const char* kind, std::size_t index, const std::string& name);

}  // namespace lumenfarm::import
