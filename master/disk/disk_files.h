#pragma once

#include "master/disk/disk.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

/// Whole files over a Disk. Errors everywhere also: those of the disk.
namespace lumenfarm {

/// Errors: bad_input (missing, or larger than `bytes_max`), failed (it became shorter while it was read).
Result<std::vector<std::byte>> read_whole(Disk& disk, const std::filesystem::path& path, std::uint64_t bytes_max);

/// Writes PATH.part, and puts it in place of PATH.
Result<void> write_whole(Disk& disk, const std::filesystem::path& path, std::span<const std::byte> bytes);

/// Syncs `file`, which is called `from`, gives it the name `to` in the same folder, and syncs the folder: after a power
/// cut there is the old `to` or the whole new one, and the new one lasts when this has succeeded. After an error `from`
/// is gone, and `to` is the old or the new one.
Result<void> put_in_place(Disk& disk, DiskFile& file, const std::filesystem::path& from,
                          const std::filesystem::path& to);

}  // namespace lumenfarm
