#pragma once

#include "master/disk/disk.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace lumenfarm {

/// The machine's own disk.
class PosixDisk : public Disk {
public:
    Result<std::unique_ptr<DiskFile>> open(const std::filesystem::path& file, DiskOpen how) override;
    bool exists(const std::filesystem::path& file) const override;
    Result<void> rename(const std::filesystem::path& from, const std::filesystem::path& to) override;
    Result<void> remove(const std::filesystem::path& file) override;
    Result<std::vector<std::string>> list(const std::filesystem::path& folder) const override;
    Result<void> make_folder(const std::filesystem::path& folder) override;
    Result<void> sync_folder(const std::filesystem::path& folder) override;
    Result<std::uint64_t> free_bytes(const std::filesystem::path& folder) const override;
};

}  // namespace lumenfarm
