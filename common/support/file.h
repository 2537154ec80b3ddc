#pragma once

#include "common/support/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// Whole files. Sentences name the path and the system's reason.
namespace lumenfarm {

/// Errors: bad_input (missing, a folder, empty is allowed, larger than `bytes_max`), failed (read error).
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t bytes_max);

/// Writes beside the path, syncs, renames, and syncs the folder: readers see the old file or the whole new one, which
/// lasts. Errors: no_space, failed.
Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
Result<void> write_file(const std::filesystem::path& path, const std::string& text);
/// Removes from the folder what write_file() of processes that ended in its midst has left there.
void remove_abandoned(const std::filesystem::path& folder);

/// The names in the folder last when this returns. Errors: failed, no_space.
Result<void> sync_folder(const std::filesystem::path& folder);

/// What the disk could not do and the system's reason `code`. no_space: full, over a quota, or too many files are open,
/// which may pass; failed: anything else.
Error disk_error(const std::string& what, int code);

/// Makes the folder and its parents. Errors: failed, when it can't be made or is a file.
Result<void> make_folder(const std::filesystem::path& path);

}  // namespace lumenfarm
