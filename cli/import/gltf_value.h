#pragma once

#include "common/math/vec.h"
#include "common/support/result.h"

#include <tiny_gltf.h>

#include <optional>
#include <string>
#include <vector>

/// Extensions and extras: JSON values of any shape, read without the library's assertions.
/// Errors: bad_input, the sentence says which member must be what; callers put the owner's name before it.
namespace lumenfarm::import {

/// Null when `value` is no object or has no such member.
const tinygltf::Value* member(const tinygltf::Value& value, const std::string& key);

/// A finite number within [low, high]; `otherwise` when it is missing.
Result<double> number_member(const tinygltf::Value& value, const std::string& key, double otherwise, double low,
                             double high);

/// Three numbers within [low, high]; `otherwise` when they are missing.
Result<Vec3d> colour_member(const tinygltf::Value& value, const std::string& key, Vec3d otherwise, double low,
                            double high);

/// Numbers of an array; nothing when `value` is not an array of finite numbers.
std::optional<std::vector<double>> numbers(const tinygltf::Value& value);

}  // namespace lumenfarm::import
