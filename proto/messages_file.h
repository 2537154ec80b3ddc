#pragma once

#include "common/support/digest.h"
#include "common/support/limits.h"
#include "proto/archive.h"
#include "proto/blocks.h"
#include "proto/message_type.h"
#include "proto/shared_types.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

/// Chunked files: compiled scenes and encoded solutions. A file's name is the SHA-256 of its bytes; it falls into
/// chunks of limits::chunk_bytes, the last may be shorter, and every chunk is checked against its digest when it
/// arrives.
namespace lumenfarm::wire {

/// Chunks of a file of so many bytes; an empty file has one.
constexpr std::uint64_t chunk_count(std::uint64_t total_bytes) {
    return total_bytes == 0 ? 1 : (total_bytes - 1) / limits::chunk_bytes + 1;
}
static_assert(chunk_count(limits::scene_bytes_max) <= limits::chunks_max);

/// What a file is made of. Part of Manifest and Submit.
struct FileManifest {
    Digest file;
    std::uint64_t total_bytes = 0;
    std::vector<Digest> chunks;  ///< exactly chunk_count(total_bytes), at most limits::chunks_max

    FileManifest() = default;
    FileManifest(const Digest& file_, std::uint64_t total_bytes_, std::vector<Digest> chunks_)
        : file(file_), total_bytes(total_bytes_), chunks(std::move(chunks_)) {}
    bool operator==(const FileManifest&) const = default;
    bool valid() const { return chunks.size() == chunk_count(total_bytes); }
    /// Bytes of a chunk. REQUIRES: valid(), index < chunks.size().
    std::size_t bytes_of_chunk(std::uint64_t index) const {
        const auto before = index * limits::chunk_bytes;
        const auto rest = total_bytes - before;
        return static_cast<std::size_t>(rest < limits::chunk_bytes ? rest : limits::chunk_bytes);
    }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, file, total_bytes, block(chunks, limits::chunks_max));
    }
};
static_assert(limits::chunks_max * sizeof(Digest) + 256 <= payload_bytes_max(MessageType::manifest));

/// worker or submitter -> master. Answered by Manifest or Refusal.
struct ManifestRequest {
    static constexpr auto type = MessageType::manifest_request;
    Digest file;

    ManifestRequest() = default;
    explicit ManifestRequest(const Digest& file_) : file(file_) {}
    bool operator==(const ManifestRequest&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, file);
    }
};

/// master -> worker or submitter.
struct Manifest {
    static constexpr auto type = MessageType::manifest;
    FileManifest manifest;

    Manifest() = default;
    explicit Manifest(FileManifest manifest_) : manifest(std::move(manifest_)) {}
    bool operator==(const Manifest&) const = default;
    bool valid() const { return manifest.valid(); }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, manifest);
    }
};

/// worker or submitter -> master. Answered by Chunk or Refusal; ask for at most limits::chunks_in_flight at a time.
struct ChunkRequest {
    static constexpr auto type = MessageType::chunk_request;
    Digest file;
    std::uint32_t index = 0;  ///< under limits::chunks_max

    ChunkRequest() = default;
    ChunkRequest(const Digest& file_, std::uint32_t index_) : file(file_), index(index_) {}
    bool operator==(const ChunkRequest&) const = default;
    bool valid() const { return index < limits::chunks_max; }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, file, index);
    }
};

/// master -> worker or submitter: the answer to ChunkRequest. submitter -> master: upload of a chunk that SubmitReply
/// named as missing (no answer).
struct Chunk {
    static constexpr auto type = MessageType::chunk;
    Digest file;
    std::uint32_t index = 0;
    std::vector<std::byte> bytes;  ///< at most limits::chunk_bytes

    Chunk() = default;
    Chunk(const Digest& file_, std::uint32_t index_, std::vector<std::byte> bytes_)
        : file(file_), index(index_), bytes(std::move(bytes_)) {}
    bool operator==(const Chunk&) const = default;
    bool valid() const { return index < limits::chunks_max; }

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, file, index, block(bytes, limits::chunk_bytes));
    }
};
static_assert(limits::chunk_bytes + 256 <= payload_bytes_max(MessageType::chunk));

}  // namespace lumenfarm::wire
