#pragma once

#include "common/support/bytes.h"
#include "common/support/result.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// A block of a file: raw size (u64), stored size (u64), then the bytes in the zstd format.
namespace lumenfarm {

using TakePiece = std::function<void(std::span<const std::byte> piece)>;

void write_block(ByteWriter& out, std::span<const std::byte> raw);
/// The same of bytes that nobody holds all at once: give(take) calls take(piece) for each piece. REQUIRES: the pieces
/// have `raw_bytes` in all.
void write_block(ByteWriter& out, std::uint64_t raw_bytes, const std::function<void(const TakePiece& take)>& give);

/// Memory taken is at most `raw_bytes_max` and never more than the block's stored bytes can unfold to.
/// Errors: bad_input (cut short, damaged, larger than allowed).
Result<std::vector<std::byte>> read_block(ByteReader& in, std::uint64_t raw_bytes_max);

}  // namespace lumenfarm
