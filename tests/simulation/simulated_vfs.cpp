#include "tests/simulation/simulated_vfs.h"

#include "common/support/ensure.h"
#include "tests/simulation/simulated_bytes.h"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <new>
#include <optional>
#include <string>
#include <utility>

namespace lumenfarm::testing {

namespace fs = std::filesystem;

struct VfsState {
    Disk& disk;
    std::uint64_t temporary_files = 0;
    std::string name;
    sqlite3_vfs vfs{};
};

namespace {

constexpr double today_julian_days = 2'460'000.5;
constexpr int path_bytes_max = 1'024;

VfsState& state_of(sqlite3_vfs* vfs) { return *static_cast<VfsState*>(vfs->pAppData); }

int code_of(const Error& error, int otherwise) { return error.code == ErrorCode::no_space ? SQLITE_FULL : otherwise; }

// A file

/// SQLite gives the memory; xOpen makes it and xClose ends it.
struct OpenFile : sqlite3_file {
    OpenFile(const sqlite3_io_methods* methods, Disk& disk_, std::unique_ptr<DiskFile> file_)
        : sqlite3_file{methods}, disk(disk_), file(std::move(file_)) {}
    Disk& disk;
    std::unique_ptr<DiskFile> file;
    std::optional<fs::path> unsynced_folder;  ///< none: the name lasts, or nothing relies on it
};

OpenFile& of(sqlite3_file* file) { return *static_cast<OpenFile*>(file); }

int close_file(sqlite3_file* file) {
    of(file).~OpenFile();
    return SQLITE_OK;
}

int read_file(sqlite3_file* file, void* to, int bytes, sqlite3_int64 offset) {
    const std::span all(static_cast<std::byte*>(to), static_cast<std::size_t>(bytes));
    const auto have = of(file).file->read(static_cast<std::uint64_t>(offset), all);
    if (!have) return SQLITE_IOERR_READ;
    if (*have == all.size()) return SQLITE_OK;
    std::ranges::fill(all.subspan(*have), std::byte{0});  // SQLite relies on it
    return SQLITE_IOERR_SHORT_READ;
}

int write_file(sqlite3_file* file, const void* from, int bytes, sqlite3_int64 offset) {
    const std::span all(static_cast<const std::byte*>(from), static_cast<std::size_t>(bytes));
    const auto written = of(file).file->write(static_cast<std::uint64_t>(offset), all);
    return written ? SQLITE_OK : code_of(written.error(), SQLITE_IOERR_WRITE);
}

int truncate_file(sqlite3_file* file, sqlite3_int64 bytes) {
    const auto truncated = of(file).file->truncate(static_cast<std::uint64_t>(bytes));
    return truncated ? SQLITE_OK : code_of(truncated.error(), SQLITE_IOERR_TRUNCATE);
}

int sync_file(sqlite3_file* file, int) {
    OpenFile& opened = of(file);
    if (!opened.file->sync()) return SQLITE_IOERR_FSYNC;
    if (!opened.unsynced_folder) return SQLITE_OK;
    if (!opened.disk.sync_folder(*opened.unsynced_folder)) return SQLITE_IOERR_DIR_FSYNC;
    opened.unsynced_folder.reset();
    return SQLITE_OK;
}

int size_of_file(sqlite3_file* file, sqlite3_int64* bytes) {
    const auto size = of(file).file->size();
    if (!size) return SQLITE_IOERR_FSTAT;
    *bytes = static_cast<sqlite3_int64>(*size);
    return SQLITE_OK;
}

int lock_file(sqlite3_file*, int) { return SQLITE_OK; }

int is_reserved(sqlite3_file*, int* reserved) {
    *reserved = 0;
    return SQLITE_OK;
}

int control_file(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
int sector_of_file(sqlite3_file*) { return static_cast<int>(sector_bytes); }
int promises_of_file(sqlite3_file*) { return SQLITE_IOCAP_POWERSAFE_OVERWRITE; }

constexpr sqlite3_io_methods make_methods() {
    sqlite3_io_methods methods{};
    methods.iVersion = 1;  // no shared memory
    methods.xClose = close_file;
    methods.xRead = read_file;
    methods.xWrite = write_file;
    methods.xTruncate = truncate_file;
    methods.xSync = sync_file;
    methods.xFileSize = size_of_file;
    methods.xLock = lock_file;
    methods.xUnlock = lock_file;
    methods.xCheckReservedLock = is_reserved;
    methods.xFileControl = control_file;
    methods.xSectorSize = sector_of_file;
    methods.xDeviceCharacteristics = promises_of_file;
    return methods;
}

constexpr sqlite3_io_methods methods_of_files = make_methods();

// The file system

/// A file without a name is seen by nobody else, and ends with the program.
Result<std::unique_ptr<DiskFile>> open_temporary(VfsState& state) {
    const fs::path path = "/sqlite-temporary-" + std::to_string(++state.temporary_files);
    auto file = state.disk.open(path, DiskOpen::make);
    if (const auto removed = state.disk.remove(path); !removed) return removed.error();
    return file;
}

int open_file(sqlite3_vfs* vfs, const char* path, sqlite3_file* to, int flags, int* flags_out) {
    VfsState& state = state_of(vfs);
    to->pMethods = nullptr;
    const auto how = (flags & SQLITE_OPEN_CREATE) != 0 ? DiskOpen::make : DiskOpen::existing;
    auto file = path ? state.disk.open(path, how) : open_temporary(state);
    if (!file) return code_of(file.error(), SQLITE_CANTOPEN);
    auto* opened = new (to) OpenFile(&methods_of_files, state.disk, std::move(*file));
    // as in SQLite's own for Unix: the name of a log lasts before anything relies on the log
    constexpr int logs = SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL | SQLITE_OPEN_SUPER_JOURNAL;
    if (path && how == DiskOpen::make && (flags & logs) != 0) opened->unsynced_folder = fs::path(path).parent_path();
    if (flags_out) *flags_out = flags;
    return SQLITE_OK;
}

int delete_file(sqlite3_vfs* vfs, const char* path, int sync) {
    Disk& disk = state_of(vfs).disk;
    if (!disk.remove(path)) return SQLITE_IOERR_DELETE;
    if (sync != 0 && !disk.sync_folder(fs::path(path).parent_path())) return SQLITE_IOERR_DIR_FSYNC;
    return SQLITE_OK;
}

int has_file(sqlite3_vfs* vfs, const char* path, int, int* has) {
    *has = state_of(vfs).disk.exists(path) ? 1 : 0;
    return SQLITE_OK;
}

int full_path(sqlite3_vfs*, const char* path, int bytes, char* to) {
    if (std::strlen(path) >= static_cast<std::size_t>(bytes)) return SQLITE_CANTOPEN;
    std::strcpy(to, path);
    return SQLITE_OK;
}

/// SQLite asks its default VFS only, and seed_random() keeps it from that.
int random_bytes(sqlite3_vfs*, int bytes, char* to) {
    std::memset(to, 0, static_cast<std::size_t>(bytes));
    return bytes;
}

/// Of the whole program's SQLite; 0: from the system.
void seed_random(int seed) {
    sqlite3* const of_no_database = nullptr;
    sqlite3_test_control(SQLITE_TESTCTRL_PRNG_SEED, seed, of_no_database);
}

int sleep(sqlite3_vfs*, int microseconds) { return microseconds; }

int current_time(sqlite3_vfs*, double* julian_days) {
    *julian_days = today_julian_days;
    return SQLITE_OK;
}

int last_error(sqlite3_vfs*, int, char*) { return 0; }

}  // namespace

SimulatedVfs::SimulatedVfs(Disk& disk, int seed) : state_(new VfsState{.disk = disk, .name = {}}) {
    state_->name = "simulated-" + std::to_string(reinterpret_cast<std::uintptr_t>(state_.get()));
    sqlite3_vfs& vfs = state_->vfs;
    vfs.iVersion = 1;
    vfs.szOsFile = sizeof(OpenFile);
    vfs.mxPathname = path_bytes_max;
    vfs.zName = state_->name.c_str();
    vfs.pAppData = state_.get();
    vfs.xOpen = open_file;
    vfs.xDelete = delete_file;
    vfs.xAccess = has_file;
    vfs.xFullPathname = full_path;
    vfs.xRandomness = random_bytes;
    vfs.xSleep = sleep;
    vfs.xCurrentTime = current_time;
    vfs.xGetLastError = last_error;
    ensure(sqlite3_vfs_register(&vfs, 0) == SQLITE_OK, "SQLite takes the VFS");
    seed_random(seed);
}

SimulatedVfs::~SimulatedVfs() {
    seed_random(0);
    sqlite3_vfs_unregister(&state_->vfs);
}

const char* SimulatedVfs::name() const { return state_->name.c_str(); }

}  // namespace lumenfarm::testing
