#include "master/disk/storage_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace lumenfarm {

Result<StorageLock> StorageLock::take(const std::filesystem::path& folder) {
    const std::filesystem::path path = folder / "lock";
    StorageLock lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
    if (lock.descriptor_ < 0) return failed("can't write '" + path.string() + "': " + std::strerror(errno));
    if (::flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0)
        return failed("the storage '" + folder.string() + "' is in use by another master");
    return lock;
}

StorageLock::~StorageLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace lumenfarm
