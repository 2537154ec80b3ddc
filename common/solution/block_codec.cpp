#include "common/solution/block_codec.h"

#include "common/support/ensure.h"

#include <zstd.h>

#include <memory>
#include <string>

namespace lumenfarm {
namespace {

constexpr int compression_level = 1;  // higher levels save a few per cent and cost ten times the time
/// One zstd block unfolds to at most 128 KiB and takes at least 3 bytes and a byte of content.
constexpr std::uint64_t expansion_max = 1u << 15;

/// One zstd frame, written as its bytes come.
class FrameWriter {
public:
    FrameWriter(ByteWriter& out, std::uint64_t raw_bytes) : out_(out), piece_(ZSTD_CStreamOutSize()) {
        ensure(context_ &&
                   !ZSTD_isError(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, compression_level)) &&
                   !ZSTD_isError(ZSTD_CCtx_setPledgedSrcSize(context_.get(), raw_bytes)),
               "zstd is ready");
    }
    void add(std::span<const std::byte> raw) { write(raw, ZSTD_e_continue); }
    void finish() { write({}, ZSTD_e_end); }

private:
    void write(std::span<const std::byte> raw, ZSTD_EndDirective directive) {
        ZSTD_inBuffer in{raw.data(), raw.size(), 0};
        std::size_t left = 0;
        do {
            ZSTD_outBuffer piece{piece_.data(), piece_.size(), 0};
            left = ZSTD_compressStream2(context_.get(), &piece, &in, directive);
            ensure(!ZSTD_isError(left), "zstd compresses as many bytes as were announced");
            out_.raw(std::span(piece_).first(piece.pos));
        } while (directive == ZSTD_e_end ? left > 0 : in.pos < in.size);
    }

    struct Free {
        void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    };
    ByteWriter& out_;
    std::unique_ptr<ZSTD_CCtx, Free> context_{ZSTD_createCCtx()};
    std::vector<std::byte> piece_;
};

}  // namespace

void write_block(ByteWriter& out, std::span<const std::byte> raw) {
    write_block(out, raw.size(), [&](const TakePiece& take) { take(raw); });
}

void write_block(ByteWriter& out, std::uint64_t raw_bytes, const std::function<void(const TakePiece& take)>& give) {
    out.value(raw_bytes);
    const std::size_t size_at = out.bytes().size();
    out.value(std::uint64_t{0});  // the stored size, known at the end
    const std::size_t begin = out.bytes().size();
    FrameWriter frame(out, raw_bytes);
    give([&](std::span<const std::byte> piece) { frame.add(piece); });
    frame.finish();
    out.replace(size_at, static_cast<std::uint64_t>(out.bytes().size() - begin));
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
