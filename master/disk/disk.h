#pragma once

#include "common/support/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// The disk as the master uses it, so that a test can put one beneath it that is full, tears and forgets. What was
/// written lasts once it is synced: bytes by DiskFile::sync, names by Disk::sync_folder. Errors everywhere: no_space
/// (full, or over a quota), failed (anything else; after a failed sync nobody knows what is on the disk). Sentences
/// name the path and the system's reason. One thread at a time.
namespace lumenfarm {

class DiskFile {
public:
    virtual ~DiskFile() = default;
    virtual Result<std::uint64_t> size() const = 0;
    /// Bytes from `offset` on, as many as fit or as there are.
    virtual Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> to) const = 0;
    /// All of them. Writing behind the end makes it longer; a gap reads as zeros.
    virtual Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
    virtual Result<void> truncate(std::uint64_t bytes) = 0;
    virtual Result<void> sync() = 0;
};

enum class DiskOpen { existing, make };  ///< make: the file, where it is missing

class Disk {
public:
    virtual ~Disk() = default;
    /// Errors also: bad_input (missing, and not to be made).
    virtual Result<std::unique_ptr<DiskFile>> open(const std::filesystem::path& file, DiskOpen how) = 0;
    virtual bool exists(const std::filesystem::path& file) const = 0;
    /// Takes the place of `to`.
    virtual Result<void> rename(const std::filesystem::path& from, const std::filesystem::path& to) = 0;
    /// A missing file is removed already.
    virtual Result<void> remove(const std::filesystem::path& file) = 0;
    /// Names of the files in the folder, sorted.
    virtual Result<std::vector<std::string>> list(const std::filesystem::path& folder) const = 0;
    /// With its parents; one that is there is fine. New ones last when this returns.
    virtual Result<void> make_folder(const std::filesystem::path& folder) = 0;
    virtual Result<void> sync_folder(const std::filesystem::path& folder) = 0;
    /// Bytes that there is still room for on the disk of the folder; a quota may allow fewer.
    virtual Result<std::uint64_t> free_bytes(const std::filesystem::path& folder) const = 0;
};

}  // namespace lumenfarm
