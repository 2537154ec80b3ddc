#include "tests/simulation/simulated_disk.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::testing {

namespace fs = std::filesystem;

namespace {

std::string cannot(const char* what, const fs::path& path) {
    return std::string("cannot ") + what + " '" + path.string() + "'";
}

Error full(const std::string& what) { return no_space(what + ": No space left on device"); }
Error broken(const std::string& what) { return failed(what + ": Input/output error"); }
Error missing(const std::string& what) { return failed(what + ": No such file or directory"); }

/// One spelling for each folder.
fs::path folder_name(const fs::path& folder) {
    const fs::path normal = folder.lexically_normal();
    const fs::path name = normal.has_filename() ? normal : normal.parent_path();  // without a slash at the end
    return name.empty() ? "." : name;
}

}  // namespace

/// Knows nothing of its disk when it ends: either may go first.
class SimulatedFile : public DiskFile {
public:
    SimulatedFile(SimulatedDisk& disk, const fs::path& path, std::shared_ptr<SimulatedBytes> bytes)
        : disk_(disk), life_(disk.life_), path_(path.string()), bytes_(std::move(bytes)) {}

    Result<std::uint64_t> size() const override {
        if (const auto on = alive("read"); !on) return on.error();
        return bytes_->seen().size();
    }
    Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> to) const override {
        if (const auto on = alive("read"); !on) return on.error();
        return disk_.read(*bytes_, path_, offset, to);
    }
    Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override {
        if (const auto on = alive("write"); !on) return on;
        return disk_.write(*bytes_, path_, offset, bytes);
    }
    Result<void> truncate(std::uint64_t bytes) override {
        if (const auto on = alive("write"); !on) return on;
        return disk_.truncate(*bytes_, path_, bytes);
    }
    Result<void> sync() override {
        if (const auto on = alive("sync"); !on) return on;
        return disk_.sync(*bytes_, path_);
    }

private:
    Result<void> alive(const char* what) const {
        if (life_ == disk_.life_) return disk_.power(cannot(what, path_));
        return failed(cannot(what, path_) + ": it was open when the power was cut");
    }

    SimulatedDisk& disk_;
    std::uint64_t life_;
    std::string path_;
    std::shared_ptr<SimulatedBytes> bytes_;
};

void SimulatedDisk::apply(const NameChange& change, Names& to) {
    auto bytes = change.made;
    if (!change.from.empty()) bytes = to.extract(change.from).mapped();
    if (!change.to.empty()) to[change.to] = std::move(bytes);
}

void SimulatedDisk::change(Folder& folder, NameChange change) {
    apply(change, folder.seen);
    folder.changes.push_back(std::move(change));
}

const SimulatedDisk::Folder* SimulatedDisk::folder_of(const fs::path& file) const {
    const auto found = folders_.find(folder_name(file.lexically_normal().parent_path()));
    return found == folders_.end() ? nullptr : &found->second;
}

SimulatedDisk::Folder* SimulatedDisk::folder_of(const fs::path& file) {
    return const_cast<Folder*>(std::as_const(*this).folder_of(file));
}

std::shared_ptr<SimulatedBytes> SimulatedDisk::find(const fs::path& file) const {
    const Folder* folder = folder_of(file);
    if (!folder) return nullptr;
    const auto found = folder->seen.find(file.filename().string());
    return found == folder->seen.end() ? nullptr : found->second;
}

Result<void> SimulatedDisk::power(const std::string& what) const {
    if (power_) return {};
    return failed(what + ": the power is off");
}

Result<void> SimulatedDisk::begin_call(const std::string& what) {
    if (const auto on = power(what); !on) return on;
    if (++calls_ == last_call_) power_ = false;
    return {};
}

bool SimulatedDisk::fails(double DiskFailures::*kind) {
    const double chance = std::max(std::exchange(next_.*kind, 0), chances_.*kind);
    return chance > 0 && std::bernoulli_distribution(std::min(chance, 1.0))(random_);
}

Result<std::unique_ptr<DiskFile>> SimulatedDisk::open(const fs::path& file, DiskOpen how) {
    const std::string what = cannot("open", file);
    if (const auto on = power(what); !on) return on.error();
    auto bytes = find(file);
    if (!bytes && how == DiskOpen::existing) return bad_input(missing(what).sentence);
    if (bytes && opens_until_failure_ > 0 && --opens_until_failure_ == 0)
        return no_space(what + ": Too many open files");
    if (!bytes) {
        Folder* folder = folder_of(file);
        if (!folder) return missing(what);
        if (const auto begun = begin_call(what); !begun) return begun.error();
        bytes = std::make_shared<SimulatedBytes>();
        change(*folder, {"", file.filename().string(), bytes});
        if (const auto on = power(what); !on) return on.error();
    }
    return std::unique_ptr<DiskFile>(new SimulatedFile(*this, file, std::move(bytes)));
}

bool SimulatedDisk::exists(const fs::path& file) const {
    return power_ && (find(file) || folders_.contains(folder_name(file)));
}

Result<void> SimulatedDisk::rename(const fs::path& from, const fs::path& to) {
    const std::string what = cannot("rename", from);
    Folder* folder = folder_of(from);
    ensure(folder == folder_of(to), "the simulated disk renames within a folder only");
    if (const auto begun = begin_call(what); !begun) return begun;
    if (!find(from)) return missing(what);
    change(*folder, {from.filename().string(), to.filename().string(), nullptr});
    return power(what);
}

Result<void> SimulatedDisk::remove(const fs::path& file) {
    const std::string what = cannot("remove", file);
    if (const auto begun = begin_call(what); !begun) return begun;
    if (find(file)) change(*folder_of(file), {file.filename().string(), "", nullptr});
    return power(what);
}

Result<std::vector<std::string>> SimulatedDisk::list(const fs::path& folder) const {
    const std::string what = cannot("list", folder);
    if (const auto on = power(what); !on) return on.error();
    const auto found = folders_.find(folder_name(folder));
    if (found == folders_.end()) return missing(what);
    std::vector<std::string> names;
    for (const auto& [name, bytes] : found->second.seen) names.push_back(name);
    return names;
}

Result<void> SimulatedDisk::make_folder(const fs::path& folder) {
    const fs::path name = folder_name(folder);
    const std::string what = cannot("make the folder", folder);
    if (const auto on = power(what); !on || folders_.contains(name)) return on;
    if (find(folder)) return failed(what + ": Not a directory");
    if (const auto parent = make_folder(name.parent_path()); !parent) return parent;
    if (const auto begun = begin_call(what); !begun) return begun;
    if (power_) folders_[name];
    return power(what);
}

Result<void> SimulatedDisk::sync_folder(const fs::path& folder) {
    const std::string what = cannot("sync the folder", folder);
    if (const auto begun = begin_call(what); !begun) return begun;
    const auto found = folders_.find(folder_name(folder));
    if (found == folders_.end()) return missing(what);
    if (fails(&DiskFailures::sync)) return broken(what);
    if (const auto on = power(what); !on) return on;
    found->second.lasting = found->second.seen;
    found->second.changes.clear();
    return {};
}

Result<std::uint64_t> SimulatedDisk::free_bytes(const fs::path&) const {
    return capacity_ - std::min(capacity_, used());
}

std::uint64_t SimulatedDisk::used() const {
    std::uint64_t bytes = 0;
    for (const auto& [name, folder] : folders_)
        for (const auto& [file, contents] : folder.seen) bytes += contents->seen().size();
    return bytes;
}

std::uint64_t SimulatedDisk::room_for(const SimulatedBytes& bytes) const {
    const std::uint64_t free = free_bytes("/").value();
    const std::uint64_t size = bytes.seen().size();
    return size + std::min(free, std::numeric_limits<std::uint64_t>::max() - size);
}

Result<std::size_t> SimulatedDisk::read(const SimulatedBytes& bytes, const std::string& path, std::uint64_t offset,
                                        std::span<std::byte> to) {
    if (fails(&DiskFailures::read)) return broken(cannot("read", path));
    const std::span<const std::byte> all = bytes.seen();
    const auto there = all.subspan(std::min<std::size_t>(offset, all.size()));
    const auto some = there.first(std::min(there.size(), to.size()));
    std::ranges::copy(some, to.begin());
    return some.size();
}

Result<void> SimulatedDisk::write(SimulatedBytes& bytes, const std::string& path, std::uint64_t offset,
                                  std::span<const std::byte> from) {
    const std::string what = cannot("write", path);
    if (const auto begun = begin_call(what); !begun) return begun;
    if (fails(&DiskFailures::write)) return broken(what);
    const std::uint64_t end = std::min(offset + from.size(), room_for(bytes));
    const bool fits = end == offset + from.size();
    if (end > offset) bytes.write(offset, from.first(end - offset));
    if (const auto on = power(what); !on || fits) return on;
    return full(what);
}

Result<void> SimulatedDisk::truncate(SimulatedBytes& bytes, const std::string& path, std::uint64_t size) {
    const std::string what = cannot("write", path);
    if (const auto begun = begin_call(what); !begun) return begun;
    if (fails(&DiskFailures::write)) return broken(what);
    if (size > room_for(bytes)) return full(what);
    bytes.truncate(size);
    return power(what);
}

Result<void> SimulatedDisk::sync(SimulatedBytes& bytes, const std::string& path) {
    const std::string what = cannot("sync", path);
    if (const auto begun = begin_call(what); !begun) return begun;
    if (const auto on = power(what); !on) return on;
    if (fails(&DiskFailures::sync)) {
        bytes.sync_badly(random_);
        return broken(what);
    }
    bytes.sync();
    return {};
}

void SimulatedDisk::crash(std::mt19937_64& random) {
    for (auto& [name, folder] : folders_) {
        const std::size_t kept = std::uniform_int_distribution<std::size_t>(0, folder.changes.size())(random);
        for (std::size_t i = 0; i < kept; ++i) apply(folder.changes[i], folder.lasting);
        folder.changes.clear();
        folder.seen = folder.lasting;
        for (const auto& [file, bytes] : folder.seen) bytes->cut_power(random);
    }
    kill();
}

void SimulatedDisk::kill() {
    power_ = true;
    last_call_.reset();
    next_ = {};
    ++life_;
}

}  // namespace lumenfarm::testing
