#pragma once

#include "master/disk/disk.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

/// A file that grows at its end. What was appended stays when keep() has followed: somebody has committed to it
/// elsewhere.
namespace lumenfarm {

class Segment {
public:
    /// A new file, whose name lasts. Errors: no_space, failed.
    static Result<Segment> make(Disk& disk, const std::filesystem::path& file);

    /// Errors: no_space, failed.
    Result<void> append(std::span<const std::byte> bytes);
    std::uint64_t bytes() const { return bytes_; }
    /// Errors: failed.
    Result<void> sync();
    void keep() { kept_bytes_ = bytes_; }
    /// Cuts off what was appended since keep(). Errors: failed.
    Result<void> undo();

private:
    explicit Segment(std::unique_ptr<DiskFile> file) : file_(std::move(file)) {}

    std::unique_ptr<DiskFile> file_;
    std::uint64_t bytes_ = 0;
    std::uint64_t kept_bytes_ = 0;
};

/// A part of a segment of whatever life. Errors: bad_input (no such file, or it ends before), failed.
Result<std::vector<std::byte>> read_segment(Disk& disk, const std::filesystem::path& file, std::uint64_t offset,
                                            std::uint64_t bytes);

}  // namespace lumenfarm
