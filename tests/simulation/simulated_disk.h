#pragma once

#include "master/disk/disk.h"
#include "tests/simulation/simulated_bytes.h"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

/// A disk in memory that forgets what was not synced, tears it, is full, and fails. No clock, no threads: one seed and
/// the same calls give the same disk. It is the worst that a journalling file system may do: bytes that were not synced
/// are written in any order or never, and the names of a folder in their order. Its folders "/" and "." are there.
namespace lumenfarm::testing {

/// Chances that a call fails.
struct DiskFailures {
    double read = 0;
    double write = 0;  ///< of bytes and lengths; nothing is written
    double sync = 0;   ///< of files and folders
};

class SimulatedDisk : public Disk {
public:
    explicit SimulatedDisk(std::uint64_t seed = 1) : random_(seed) {}

    Result<std::unique_ptr<DiskFile>> open(const std::filesystem::path& file, DiskOpen how) override;
    bool exists(const std::filesystem::path& file) const override;
    /// REQUIRES: both in one folder.
    Result<void> rename(const std::filesystem::path& from, const std::filesystem::path& to) override;
    Result<void> remove(const std::filesystem::path& file) override;
    Result<std::vector<std::string>> list(const std::filesystem::path& folder) const override;
    Result<void> make_folder(const std::filesystem::path& folder) override;
    Result<void> sync_folder(const std::filesystem::path& folder) override;
    Result<std::uint64_t> free_bytes(const std::filesystem::path& folder) const override;

    /// Calls so far that change something or make it last: write, truncate, sync, rename, remove, sync_folder, and
    /// those of open and make_folder that make something.
    std::uint64_t calls() const { return calls_; }
    /// The power fails during the n-th of these calls from now, 1 being the next: it fails, and what it was to do is
    /// done or not, as of any other that was not synced. From then on every call fails until crash().
    void crash_at(std::uint64_t n) { last_call_ = calls_ + n; }
    void power_off() { power_ = false; }
    bool has_power() const { return power_; }
    /// The power was off and is on again: `random` decides what is left of all that was not synced. Files that were
    /// open fail forever. Whoever had them must be gone before: it could remove or rename files of the new life.
    void crash(std::mt19937_64& random);
    /// As crash(), but only the program was killed: the system goes on, and nothing is lost yet.
    void kill();

    /// Bytes that all files may have together. A write beyond gives no_space, and writes what fits.
    void set_capacity(std::uint64_t bytes) { capacity_ = bytes; }
    std::uint64_t used() const;

    /// Too many files are open at the n-th that is opened from now and is there, 1 being the next.
    void fail_open_at(std::uint64_t n) { opens_until_failure_ = n; }
    void fail_next_read() { next_.read = 1; }
    void fail_next_write() { next_.write = 1; }
    /// Of a file or a folder. Some of the file's changes will never last, whatever syncs succeed later.
    void fail_next_sync() { next_.sync = 1; }
    void fail_sometimes(const DiskFailures& chances) { chances_ = chances; }

private:
    friend class SimulatedFile;

    using Names = std::map<std::string, std::shared_ptr<SimulatedBytes>>;
    struct NameChange {
        std::string from;                      ///< empty: a file is made
        std::string to;                        ///< empty: it is removed
        std::shared_ptr<SimulatedBytes> made;  ///< only when it is made
    };
    struct Folder {
        Names seen;
        Names lasting;
        std::vector<NameChange> changes;  ///< since the last sync, in their order
    };

    static void apply(const NameChange& change, Names& to);
    static void change(Folder& folder, NameChange change);
    /// Null: there is no such folder.
    Folder* folder_of(const std::filesystem::path& file);
    const Folder* folder_of(const std::filesystem::path& file) const;
    std::shared_ptr<SimulatedBytes> find(const std::filesystem::path& file) const;

    /// Counts a call, during which the power may fail. Fails when it is off already.
    Result<void> begin_call(const std::string& what);
    Result<void> power(const std::string& what) const;
    bool fails(double DiskFailures::*kind);

    Result<std::size_t> read(const SimulatedBytes& bytes, const std::string& path, std::uint64_t offset,
                             std::span<std::byte> to);
    Result<void> write(SimulatedBytes& bytes, const std::string& path, std::uint64_t offset,
                       std::span<const std::byte> from);
    Result<void> truncate(SimulatedBytes& bytes, const std::string& path, std::uint64_t size);
    Result<void> sync(SimulatedBytes& bytes, const std::string& path);
    /// How many bytes the file may have.
    std::uint64_t room_for(const SimulatedBytes& bytes) const;

    std::mt19937_64 random_;
    std::map<std::filesystem::path, Folder> folders_{{"/", {}}, {".", {}}};
    std::uint64_t life_ = 1;  ///< power cuts end one
    bool power_ = true;
    std::uint64_t calls_ = 0;
    std::optional<std::uint64_t> last_call_;
    std::uint64_t capacity_ = std::numeric_limits<std::uint64_t>::max();
    DiskFailures chances_;
    DiskFailures next_;
    std::uint64_t opens_until_failure_ = 0;  ///< 0: there is none
};

}  // namespace lumenfarm::testing
