#pragma once

#include "common/support/digest.h"
#include "common/support/result.h"
#include "master/disk/disk.h"
#include "proto/messages.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

/// Files by the digest of their bytes: FOLDER/<64 hex digits>. A file that has its name is whole and lasts; on its way
/// it is FOLDER/<64 hex digits>.upload or .part. Errors everywhere: no_space and failed, of the disk. Not thread-safe.
namespace lumenfarm {

class FileStore {
public:
    /// The disk must stay.
    FileStore(Disk& disk, std::filesystem::path folder) : disk_(disk), folder_(std::move(folder)) {}

    /// Makes the folder and removes what an earlier life had on its way.
    Result<void> open();

    /// The chunks that are not here yet; none when the whole file is. Begins an upload, in place of the oldest one when
    /// limits::uploads_max are on their way.
    Result<std::vector<std::uint32_t>> missing(const wire::FileManifest& manifest);
    /// Keeps a chunk of an upload; with the last one the file appears. Errors: bad_input (no such upload, or other
    /// bytes than its digest says). The chunk stays missing after an error; after one of the last chunk all are.
    Result<void> put_chunk(const wire::Chunk& chunk);
    Result<Digest> put(std::span<const std::byte> bytes);

    /// Files whose uploads were dropped for newer ones, since the last call.
    std::vector<Digest> take_displaced() { return std::exchange(displaced_, {}); }

    /// The whole file, verified. Errors: bad_input (not here, or damaged), failed.
    Result<std::vector<std::byte>> read(const Digest& file) const;
    /// Errors: as read().
    Result<wire::FileManifest> manifest(const Digest& file);
    /// Not verified: who gets it does that. Errors: bad_input (no such file, or it has no such chunk).
    Result<std::vector<std::byte>> chunk(const Digest& file, std::uint32_t index) const;
    /// What is replied to who asks for a file: Manifest, Chunk or Refusal.
    wire::Message answer(const wire::ManifestRequest& request);
    wire::Message answer(const wire::ChunkRequest& request) const;
    std::filesystem::path path(const Digest& file) const { return folder_ / file.hex(); }

    /// One that is missing is removed already. A power cut may bring it back.
    Result<void> remove(const Digest& file);
    /// Removes every file that is not `kept`, uploads left alone, and says how many. A power cut may bring some back.
    Result<std::uint64_t> remove_others(const std::set<Digest>& kept);

private:
    struct Upload {
        wire::FileManifest manifest;
        std::unique_ptr<DiskFile> file;  ///< at upload_path()
        std::vector<bool> received;
        std::size_t left = 0;
    };
    std::filesystem::path upload_path(const Digest& file) const { return folder_ / (file.hex() + ".upload"); }
    Result<void> begin(const wire::FileManifest& manifest);
    Result<void> displace(std::list<Upload>::iterator upload);
    Result<void> drop(std::list<Upload>::iterator upload);
    Result<void> keep(Upload& upload, const wire::Chunk& chunk);
    Result<void> finish(Upload& upload);

    Disk& disk_;
    std::filesystem::path folder_;
    std::list<Upload> uploads_;  ///< oldest first
    std::vector<Digest> displaced_;
    std::list<wire::FileManifest> manifests_;  ///< asked for lately, newest first
};

}  // namespace lumenfarm
