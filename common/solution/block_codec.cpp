#include "common/solution/block_codec.h"

#include "common/support/ensure.h"

#include <zstd.h>

#include <string>

namespace lumenfarm {
namespace {

constexpr int compression_level = 1;  // higher levels save a few per cent and cost ten times the time
/// One zstd block unfolds to at most 128 KiB and takes at least 3 bytes and a byte of content.
constexpr std::uint64_t expansion_max = 1u << 15;

}  // namespace

void write_block(ByteWriter& out, std::span<const std::byte> raw) {
    std::vector<std::byte> stored(ZSTD_compressBound(raw.size()));
    const std::size_t size = ZSTD_compress(stored.data(), stored.size(), raw.data(), raw.size(), compression_level);
    ensure(ZSTD_isError(size) == 0, "zstd compresses into a buffer of its own bound");
    stored.resize(size);
    out.value(static_cast<std::uint64_t>(raw.size()));
    out.block(std::span<const std::byte>(stored));
}

Result<std::vector<std::byte>> read_block(ByteReader& in, std::uint64_t raw_bytes_max) {
    const auto raw_size = in.value<std::uint64_t>();
    const auto stored = in.block<std::byte>(in.remaining());
    if (!in.good()) return bad_input("a section is cut short");
    if (raw_size > raw_bytes_max)
        return bad_input("a section has " + std::to_string(raw_size) + " bytes where " + std::to_string(raw_bytes_max) +
                         " are the limit");
    if (raw_size / expansion_max > stored.size()) return bad_input("a section cannot unfold to the size it states");
    std::vector<std::byte> raw(raw_size);
    const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size());
    if (ZSTD_isError(size) != 0 || size != raw_size) return bad_input("a section is damaged");
    return raw;
}

}  // namespace lumenfarm
