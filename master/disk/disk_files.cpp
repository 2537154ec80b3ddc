#include "master/disk/disk_files.h"

#include <string>

namespace lumenfarm {

namespace {

Result<void> fill(DiskFile& file, std::span<const std::byte> bytes) {
    // an earlier life may have left more there
    if (const auto emptied = file.truncate(0); !emptied) return emptied;
    return file.write(0, bytes);
}

Result<void> sync_and_rename(Disk& disk, DiskFile& file, const std::filesystem::path& from,
                             const std::filesystem::path& to) {
    if (const auto synced = file.sync(); !synced) return synced;
    return disk.rename(from, to);
}

}  // namespace

Result<std::vector<std::byte>> read_whole(Disk& disk, const std::filesystem::path& path, std::uint64_t bytes_max) {
    const auto file = disk.open(path, DiskOpen::existing);
    if (!file) return file.error();
    const auto size = (*file)->size();
    if (!size) return size.error();
    if (*size > bytes_max)
        return bad_input("'" + path.string() + "' has " + std::to_string(*size) + " bytes; the limit is " +
                         std::to_string(bytes_max));
    std::vector<std::byte> bytes(*size);
    const auto have = (*file)->read(0, bytes);
    if (!have) return have.error();
    if (*have < bytes.size()) return failed("'" + path.string() + "' became shorter while it was read");
    return bytes;
}

Result<void> write_whole(Disk& disk, const std::filesystem::path& path, std::span<const std::byte> bytes) {
    std::filesystem::path part = path;
    part += ".part";
    const auto file = disk.open(part, DiskOpen::make);
    if (!file) return file.error();
    if (const auto filled = fill(**file, bytes); !filled) {
        (void)disk.remove(part);
        return filled;
    }
    return put_in_place(disk, **file, part, path);
}

Result<void> put_in_place(Disk& disk, DiskFile& file, const std::filesystem::path& from,
                          const std::filesystem::path& to) {
    if (const auto renamed = sync_and_rename(disk, file, from, to); !renamed) {
        (void)disk.remove(from);
        return renamed;
    }
    return disk.sync_folder(to.parent_path());
}

}  // namespace lumenfarm
