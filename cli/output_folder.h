#pragma once

#include "common/support/result.h"

#include <filesystem>

namespace lumenfarm {

/// A folder for results, found writable before any work is done. Unless kept, it is removed again when it was made here
/// and is still empty. Files in it that were being written when the program ended at once can be swept away.
class OutputFolder {
public:
    /// Makes the folder with its parents. Errors: failed (cannot be made, or not written into).
    static Result<OutputFolder> open(const std::filesystem::path& path);
    OutputFolder(OutputFolder&& other) noexcept;
    OutputFolder& operator=(OutputFolder&&) = delete;
    ~OutputFolder();

    const std::filesystem::path& path() const { return path_; }
    /// Removes what write_file() of this process had not finished.
    void sweep() const;

private:
    OutputFolder(std::filesystem::path path, bool made) : path_(std::move(path)), made_(made) {}
    std::filesystem::path path_;
    bool made_;  ///< the last folder of the path did not exist before
};

/// Errors: failed, when a file cannot be written at `path` (its folder is missing, read-only, or `path` is a folder).
Result<void> check_file_writable(const std::filesystem::path& path);

}  // namespace lumenfarm
