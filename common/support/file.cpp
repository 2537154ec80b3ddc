#include "common/support/file.h"

#include "common/support/descriptor.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <string_view>
#include <utility>

namespace lumenfarm {
namespace {

constexpr std::string_view beside_mark = ".part-";  ///< before the number of the process that writes

std::string reason() { return std::strerror(errno); }

bool write_all(int fd, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(fd, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return true;
}

}  // namespace

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t bytes_max) {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    struct stat status {};
    if (file.get() < 0 || ::fstat(file.get(), &status) != 0)
        return bad_input("cannot read '" + path.string() + "': " + reason());
    if (!S_ISREG(status.st_mode)) return bad_input("cannot read '" + path.string() + "': it is not a regular file");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > bytes_max)
        return bad_input("'" + path.string() + "' has " + std::to_string(size) + " bytes; the limit is " +
                         std::to_string(bytes_max));
    std::vector<std::byte> bytes(size);
    std::size_t have = 0;
    while (have < bytes.size()) {
        const ssize_t got = ::read(file.get(), bytes.data() + have, bytes.size() - have);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return failed("cannot read '" + path.string() + "': " + reason());
        if (got == 0) return failed("'" + path.string() + "' became shorter while it was read");
        have += static_cast<std::size_t>(got);
    }
    return bytes;
}

Error disk_error(const std::string& what, int code) {
    std::string sentence = what + ": " + std::strerror(code);
    if (code == ENOSPC || code == EDQUOT || code == EMFILE || code == ENFILE) return no_space(std::move(sentence));
    return failed(std::move(sentence));
}

Result<void> sync_folder(const std::filesystem::path& folder) {
    const Descriptor opened(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    // a folder that only takes files can't be opened, and some file systems have nothing to sync here
    const bool nothing_to_do = opened.get() < 0 ? errno == EACCES : ::fsync(opened.get()) == 0 || errno == EINVAL;
    if (nothing_to_do) return {};
    return disk_error("cannot sync the folder '" + folder.string() + "'", errno);
}

Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
    const std::string beside = path.string() + std::string(beside_mark) + std::to_string(::getpid());
    const auto fails = [&](int code) {
        ::unlink(beside.c_str());
        return disk_error("cannot write '" + path.string() + "'", code);
    };
    {
        const Descriptor file(::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
        if (file.get() < 0 || !write_all(file.get(), bytes) || ::fsync(file.get()) != 0) return fails(errno);
    }
    if (::rename(beside.c_str(), path.c_str()) != 0) return fails(errno);
    return sync_folder(path.parent_path());
}

Result<void> write_file(const std::filesystem::path& path, const std::string& text) {
    return write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

void remove_abandoned(const std::filesystem::path& folder) {
    std::error_code error;
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::string name = at->path().filename().string();
        const auto mark = name.rfind(beside_mark);
        if (mark == std::string::npos) continue;
        pid_t writer = 0;
        const char* last = name.data() + name.size();
        const auto read = std::from_chars(name.data() + mark + beside_mark.size(), last, writer);
        if (read.ec != std::errc() || read.ptr != last || writer <= 0) continue;
        std::error_code ignored;
        if (::kill(writer, 0) != 0 && errno == ESRCH) std::filesystem::remove(at->path(), ignored);
    }
}

Result<void> make_folder(const std::filesystem::path& path) {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error || !std::filesystem::is_directory(path, error))
        return failed("cannot make the folder '" + path.string() + "'" + (error ? ": " + error.message() : ""));
    return {};
}

}  // namespace lumenfarm
