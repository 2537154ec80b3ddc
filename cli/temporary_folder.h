#pragma once

#include "common/support/result.h"

#include <filesystem>

namespace lumenfarm {

/// A folder of its own under $TMPDIR, removed with all that is in it.
class TemporaryFolder {
public:
    /// Errors: failed.
    static Result<TemporaryFolder> make();
    TemporaryFolder(TemporaryFolder&& other) noexcept;
    TemporaryFolder& operator=(TemporaryFolder&&) = delete;
    ~TemporaryFolder() { remove(); }

    const std::filesystem::path& path() const { return path_; }
    /// As far as that is possible; others may still write into it.
    void remove() const;

private:
    explicit TemporaryFolder(std::filesystem::path path) : path_(std::move(path)) {}
    std::filesystem::path path_;
};

}  // namespace lumenfarm
