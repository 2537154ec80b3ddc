#include "cli/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

namespace lumenfarm {

Result<TemporaryFolder> TemporaryFolder::make() {
    std::error_code error;
    const auto parent = std::filesystem::temp_directory_path(error);
    if (error) return failed("there is no folder for temporary files ($TMPDIR): " + error.message());
    std::string name = (parent / "lumenfarm-XXXXXX").string();
    if (!::mkdtemp(name.data()))
        return failed("cannot make a folder in '" + parent.string() + "': " + std::strerror(errno));
    return TemporaryFolder(name);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}

void TemporaryFolder::remove() const {
    std::error_code error;
    if (!path_.empty()) std::filesystem::remove_all(path_, error);
}

}  // namespace lumenfarm
