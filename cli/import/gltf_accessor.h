#pragma once

#include "cli/import/gltf_file.h"

#include <cstdint>
#include <vector>

/// Checked reading of accessors: every byte that is touched lies in its buffer; counts are checked before memory is
/// taken. Errors: bad_input with the accessor's number.
namespace lumenfarm::import {

/// Scalars of an unsigned integer type: indices.
Result<std::vector<std::uint32_t>> read_indices(const tinygltf::Model& model, int accessor,
                                                const SceneBuilder& builder);

/// `components` numbers an element, row by row; normalised integers become [0, 1] or [-1, 1]. Sparse ones are resolved.
Result<std::vector<double>> read_numbers(const tinygltf::Model& model, int accessor, int components,
                                         const SceneBuilder& builder);

}  // namespace lumenfarm::import
