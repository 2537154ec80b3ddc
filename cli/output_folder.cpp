#include "cli/output_folder.h"

#include "common/support/file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

namespace lumenfarm {
namespace {

Error cannot_write(const std::filesystem::path& path, const std::string& why) {
    return failed("cannot write '" + path.string() + "': " + why);
}

/// Creates and removes a file, since permission bits alone do not tell (read-only disks, quotas, root).
Result<void> probe(const std::filesystem::path& folder, const std::filesystem::path& wanted) {
    std::string name = (folder / ".lumenfarm-XXXXXX").string();
    const int file = ::mkstemp(name.data());
    if (file < 0) return cannot_write(wanted, std::strerror(errno));
    ::close(file);
    ::unlink(name.c_str());
    return {};
}

}  // namespace

Result<OutputFolder> OutputFolder::open(const std::filesystem::path& path) {
    if (path.empty()) return bad_input("the output folder's name is empty");
    std::error_code error;
    const bool made = !std::filesystem::exists(path, error);
    if (auto ready = make_folder(path); !ready) return ready.error();
    OutputFolder folder(path, made);
    if (auto writable = probe(path, path); !writable) return writable.error();
    return folder;
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : path_(std::move(other.path_)), made_(std::exchange(other.made_, false)) {}

OutputFolder::~OutputFolder() {
    std::error_code error;
    if (made_ && std::filesystem::is_empty(path_, error) && !error) std::filesystem::remove(path_, error);
}

void OutputFolder::sweep() const {
    const std::string mark = ".part-" + std::to_string(::getpid());
    std::error_code error;
    for (std::filesystem::directory_iterator entry(path_, error), end; !error && entry != end; entry.increment(error))
        if (entry->path().filename().string().ends_with(mark)) ::unlink(entry->path().c_str());
    if (made_ && std::filesystem::is_empty(path_, error)) ::rmdir(path_.c_str());
}

Result<void> check_file_writable(const std::filesystem::path& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) return cannot_write(path, "it is a folder");
    const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(folder, error)) return cannot_write(path, "its folder does not exist");
    return probe(folder, path);
}

}  // namespace lumenfarm
