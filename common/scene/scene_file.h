#pragma once

#include "common/scene/scene.h"
#include "common/support/digest.h"
#include "common/support/result.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

/// The bytes of a compiled scene (docs/scene_file.md). Little-endian; the same scene gives the same bytes.
namespace lumenfarm {

/// Every statement that scene.h makes of its fields (index ranges, finite numbers, sorted triangles, albedos in [0, 1],
/// limits). Errors: bad_input with one sentence that names the element and the value.
Result<void> validate(const Scene& scene);
/// The part of that which is about positions, texture coordinates and triangles; there may be none.
Result<void> validate_geometry(const Scene& scene);

/// REQUIRES: validate(scene) succeeds.
std::vector<std::byte> encode_scene(const Scene& scene);

/// Reads and validates foreign bytes: memory taken is bounded by a small multiple of bytes.size().
/// Errors: bad_input with a sentence.
Result<Scene> decode_scene(std::span<const std::byte> bytes);

/// SHA-256 of the bytes: the scene's name.
Digest scene_digest(std::span<const std::byte> scene_bytes);

/// Digests of the chunks of limits::chunk_bytes that the bytes fall into (the last may be shorter; at least one).
std::vector<Digest> chunk_digests(std::span<const std::byte> scene_bytes);

}  // namespace lumenfarm
