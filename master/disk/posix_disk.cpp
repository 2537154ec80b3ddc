#include "master/disk/posix_disk.h"

#include "common/support/descriptor.h"
#include "common/support/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

namespace lumenfarm {

namespace fs = std::filesystem;

namespace {

std::string cannot(const char* what, const fs::path& path) {
    return std::string("cannot ") + what + " '" + path.string() + "'";
}

/// Calls again what a signal has interrupted.
template <class Call>
auto uninterrupted(Call call) {
    auto result = call();
    while (result < 0 && errno == EINTR) result = call();
    return result;
}

class PosixFile : public DiskFile {
public:
    PosixFile(fs::path path, Descriptor file) : path_(std::move(path)), file_(std::move(file)) {}

    Result<std::uint64_t> size() const override {
        struct stat status {};
        if (::fstat(file_.get(), &status) != 0) return disk_error(cannot("read", path_), errno);
        return static_cast<std::uint64_t>(status.st_size);
    }

    Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> to) const override {
        std::size_t have = 0;
        while (have < to.size()) {
            const auto at = static_cast<off_t>(offset + have);
            const ssize_t got =
                uninterrupted([&] { return ::pread(file_.get(), to.data() + have, to.size() - have, at); });
            if (got < 0) return disk_error(cannot("read", path_), errno);
            if (got == 0) break;
            have += static_cast<std::size_t>(got);
        }
        return have;
    }

    Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override {
        while (!bytes.empty()) {
            const auto at = static_cast<off_t>(offset);
            const ssize_t put = uninterrupted([&] { return ::pwrite(file_.get(), bytes.data(), bytes.size(), at); });
            if (put <= 0) return disk_error(cannot("write", path_), put == 0 ? EIO : errno);
            offset += static_cast<std::uint64_t>(put);
            bytes = bytes.subspan(static_cast<std::size_t>(put));
        }
        return {};
    }

    Result<void> truncate(std::uint64_t bytes) override {
        if (uninterrupted([&] { return ::ftruncate(file_.get(), static_cast<off_t>(bytes)); }) == 0) return {};
        return disk_error(cannot("write", path_), errno);
    }

    Result<void> sync() override {
        // fdatasync: the length lasts, too; the times of access need not
        if (uninterrupted([&] { return ::fdatasync(file_.get()); }) == 0) return {};
        return disk_error(cannot("sync", path_), errno);
    }

private:
    fs::path path_;
    Descriptor file_;
};

}  // namespace

Result<std::unique_ptr<DiskFile>> PosixDisk::open(const fs::path& file, DiskOpen how) {
    const int flags = O_RDWR | O_CLOEXEC | (how == DiskOpen::make ? O_CREAT : 0);
    Descriptor opened(uninterrupted([&] { return ::open(file.c_str(), flags, 0644); }));
    const int code = errno;
    if (opened.get() >= 0) return std::unique_ptr<DiskFile>(new PosixFile(file, std::move(opened)));
    Error error = disk_error(cannot("open", file), code);
    if (code == ENOENT && how == DiskOpen::existing) error.code = ErrorCode::bad_input;
    return error;
}

bool PosixDisk::exists(const fs::path& file) const {
    std::error_code ignored;
    return fs::exists(file, ignored);
}

Result<void> PosixDisk::rename(const fs::path& from, const fs::path& to) {
    if (::rename(from.c_str(), to.c_str()) == 0) return {};
    return disk_error(cannot("rename", from), errno);
}

Result<void> PosixDisk::remove(const fs::path& file) {
    if (::unlink(file.c_str()) == 0 || errno == ENOENT) return {};
    return disk_error(cannot("remove", file), errno);
}

Result<std::vector<std::string>> PosixDisk::list(const fs::path& folder) const {
    std::error_code error;
    std::vector<std::string> names;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (std::error_code ignored; at->is_regular_file(ignored)) names.push_back(at->path().filename().string());
    if (error) return disk_error(cannot("list", folder), error.value());
    std::ranges::sort(names);
    return names;
}

Result<void> PosixDisk::make_folder(const fs::path& folder) {
    // what has no file name ends in a slash
    const fs::path parent = folder.has_filename() ? folder.parent_path() : folder.parent_path().parent_path();
    std::error_code ignored;
    if (fs::is_directory(folder, ignored)) return {};
    if (!parent.empty() && parent != folder)
        if (const auto made = make_folder(parent); !made) return made;
    if (const auto made = lumenfarm::make_folder(folder); !made) return made;
    return sync_folder(parent);
}

Result<void> PosixDisk::sync_folder(const fs::path& folder) { return lumenfarm::sync_folder(folder); }

Result<std::uint64_t> PosixDisk::free_bytes(const fs::path& folder) const {
    std::error_code error;
    const fs::space_info space = fs::space(folder, error);
    if (error) return disk_error(cannot("read", folder), error.value());
    return space.available;
}

}  // namespace lumenfarm
