#pragma once

#include "common/support/result.h"

#include <filesystem>
#include <utility>

namespace lumenfarm {

/// Holds FOLDER/lock, so that two masters never share a storage.
class StorageLock {
public:
    /// Errors: failed, when the file can't be made or another process holds it.
    static Result<StorageLock> take(const std::filesystem::path& folder);
    StorageLock(StorageLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    StorageLock& operator=(StorageLock&&) = delete;
    ~StorageLock();

private:
    explicit StorageLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_;
};

}  // namespace lumenfarm
