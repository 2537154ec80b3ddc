#pragma once

#include "common/support/digest.h"
#include "common/support/result.h"
#include "proto/messages_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <span>
#include <utility>
#include <vector>

/// Files by the digest of their bytes: FOLDER/<64 hex digits>; uploads on their way are FOLDER/<64 hex digits>.part.
/// Not thread-safe.
namespace lumenfarm {

class FileStore {
public:
    explicit FileStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Makes the folder and removes uploads of an earlier life. Errors: failed.
    Result<void> open();

    /// The chunks that are not here yet; none when the whole file is. Begins an upload, in place of the oldest one when
    /// limits::uploads_max are on their way. Errors: failed.
    Result<std::vector<std::uint32_t>> missing(const wire::FileManifest& manifest);
    /// Keeps a chunk of an upload; with the last one the file appears. Errors: bad_input (no such upload, or other
    /// bytes than its digest says: it stays missing), failed (disk).
    Result<void> put_chunk(const wire::Chunk& chunk);
    /// Errors: failed.
    Result<Digest> put(std::span<const std::byte> bytes);

    /// The whole file, verified. Errors: bad_input (not here), failed (damaged).
    Result<std::vector<std::byte>> read(const Digest& file) const;
    Result<wire::FileManifest> manifest(const Digest& file);
    Result<std::vector<std::byte>> chunk(const Digest& file, std::uint32_t index) const;
    std::filesystem::path path(const Digest& file) const { return folder_ / file.hex(); }

private:
    struct Upload {
        wire::FileManifest manifest;
        std::vector<bool> received;
        std::size_t left = 0;
    };
    std::filesystem::path part_path(const Digest& file) const { return folder_ / (file.hex() + ".part"); }
    Result<void> finish(const Digest& file);

    std::filesystem::path folder_;
    std::list<Upload> uploads_;                ///< oldest first
    std::list<wire::FileManifest> manifests_;  ///< asked for lately, newest first
};

}  // namespace lumenfarm
