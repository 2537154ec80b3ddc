#include "master/disk/segment.h"

namespace lumenfarm {

Result<Segment> Segment::make(Disk& disk, const std::filesystem::path& file) {
    auto made = disk.open(file, DiskOpen::make);
    if (!made) return made.error();
    if (const auto empty = (*made)->truncate(0); !empty) return empty.error();
    if (const auto named = disk.sync_folder(file.parent_path()); !named) return named.error();
    return Segment(std::move(*made));
}

Result<void> Segment::append(std::span<const std::byte> bytes) {
    auto written = file_->write(bytes_, bytes);
    if (written) bytes_ += bytes.size();
    return written;
}

Result<void> Segment::sync() { return file_->sync(); }

Result<void> Segment::undo() {
    bytes_ = kept_bytes_;
    return file_->truncate(kept_bytes_);
}

Result<std::vector<std::byte>> read_segment(Disk& disk, const std::filesystem::path& file, std::uint64_t offset,
                                            std::uint64_t bytes) {
    const auto opened = disk.open(file, DiskOpen::existing);
    if (!opened) return opened.error();
    const auto size = (*opened)->size();
    if (!size) return size.error();
    // before memory is taken for it
    if (offset > *size || bytes > *size - offset) return bad_input("'" + file.string() + "' is cut short");
    std::vector<std::byte> read(bytes);
    const auto got = (*opened)->read(offset, read);
    if (!got) return got.error();
    if (*got != bytes) return failed("'" + file.string() + "' became shorter while it was read");
    return read;
}

}  // namespace lumenfarm
