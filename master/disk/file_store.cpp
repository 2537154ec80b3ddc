#include "master/disk/file_store.h"

#include "common/scene/scene_file.h"
#include "common/support/limits.h"
#include "master/disk/disk_files.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

namespace lumenfarm {

namespace fs = std::filesystem;

namespace {

bool is_on_its_way(std::string_view name) { return name.ends_with(".part") || name.ends_with(".upload"); }

}  // namespace

Result<void> FileStore::open() {
    if (const auto made = disk_.make_folder(folder_); !made) return made;
    const auto names = disk_.list(folder_);
    if (!names) return names.error();
    for (const std::string& name : *names)
        if (is_on_its_way(name))
            if (const auto removed = disk_.remove(folder_ / name); !removed) return removed;
    // a life that was killed may have given a name and not synced it
    return disk_.sync_folder(folder_);
}

Result<std::vector<std::uint32_t>> FileStore::missing(const wire::FileManifest& manifest) {
    if (disk_.exists(path(manifest.file))) return std::vector<std::uint32_t>{};
    const auto same = [&](const Upload& upload) { return upload.manifest == manifest; };
    auto upload = std::ranges::find_if(uploads_, same);
    if (upload == uploads_.end()) {
        if (const auto begun = begin(manifest); !begun) return begun.error();
        upload = std::prev(uploads_.end());
    }
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < upload->received.size(); ++i)
        if (!upload->received[i]) indices.push_back(i);
    return indices;
}

Result<void> FileStore::begin(const wire::FileManifest& manifest) {
    // one of the same file with other chunks would write to the same place
    const auto of_file = [&](const Upload& upload) { return upload.manifest.file == manifest.file; };
    if (const auto other = std::ranges::find_if(uploads_, of_file); other != uploads_.end())
        if (const auto dropped = displace(other); !dropped) return dropped;
    if (uploads_.size() >= limits::uploads_max)
        if (const auto dropped = displace(uploads_.begin()); !dropped) return dropped;
    auto file = disk_.open(upload_path(manifest.file), DiskOpen::make);
    if (!file) return file.error();
    const std::size_t chunks = manifest.chunks.size();
    uploads_.push_back({manifest, std::move(*file), std::vector<bool>(chunks, false), chunks});
    return {};
}

Result<void> FileStore::displace(std::list<Upload>::iterator upload) {
    displaced_.push_back(upload->manifest.file);
    return drop(upload);
}

Result<void> FileStore::drop(std::list<Upload>::iterator upload) {
    const Digest file = upload->manifest.file;
    uploads_.erase(upload);
    return disk_.remove(upload_path(file));
}

Result<void> FileStore::put_chunk(const wire::Chunk& chunk) {
    const auto of_file = [&](const Upload& upload) { return upload.manifest.file == chunk.file; };
    const auto upload = std::ranges::find_if(uploads_, of_file);
    if (upload == uploads_.end() || chunk.index >= upload->received.size())
        return bad_input("chunk " + std::to_string(chunk.index) + " of " + chunk.file.hex() + " was not asked for");
    if (upload->received[chunk.index]) return {};
    if (const auto kept = keep(*upload, chunk); !kept || upload->left > 0) return kept;
    const auto finished = finish(*upload);
    const auto dropped = drop(upload);
    return finished ? dropped : finished;
}

Result<void> FileStore::keep(Upload& upload, const wire::Chunk& chunk) {
    if (chunk.bytes.size() != upload.manifest.bytes_of_chunk(chunk.index) ||
        sha256(chunk.bytes) != upload.manifest.chunks[chunk.index])
        return bad_input("chunk " + std::to_string(chunk.index) + " of " + chunk.file.hex() + " is damaged");
    const std::uint64_t offset = chunk.index * std::uint64_t{limits::chunk_bytes};
    if (const auto written = upload.file->write(offset, chunk.bytes); !written) return written;
    upload.received[chunk.index] = true;
    --upload.left;
    return {};
}

/// The whole is verified before it gets its name.
Result<void> FileStore::finish(Upload& upload) {
    const Digest& file = upload.manifest.file;
    if (disk_.exists(path(file))) return {};  // put() was first
    const auto bytes = read_whole(disk_, upload_path(file), limits::scene_bytes_max);
    if (!bytes) return bytes.error();
    if (sha256(*bytes) != file) return bad_input("the chunks of " + file.hex() + " make another file");
    const auto placed = put_in_place(disk_, *upload.file, upload_path(file), path(file));
    // a name that may not last is taken away again, or the next who asks would rely on it
    if (!placed) (void)disk_.remove(path(file));
    return placed;
}

Result<Digest> FileStore::put(std::span<const std::byte> bytes) {
    const Digest file = sha256(bytes);
    const bool was_here = disk_.exists(path(file));
    if (const auto written = write_whole(disk_, path(file), bytes); !written) {
        if (!was_here) (void)disk_.remove(path(file));
        return written.error();
    }
    return file;
}

Result<std::vector<std::byte>> FileStore::read(const Digest& file) const {
    auto bytes = read_whole(disk_, path(file), limits::solution_bytes_max);
    if (bytes && sha256(*bytes) != file)
        return bad_input("'" + path(file).string() + "' is damaged: its digest differs");
    return bytes;
}

Result<wire::FileManifest> FileStore::manifest(const Digest& file) {
    const auto same = [&](const wire::FileManifest& manifest) { return manifest.file == file; };
    if (const auto known = std::ranges::find_if(manifests_, same); known != manifests_.end()) return *known;
    const auto bytes = read(file);
    if (!bytes) return bytes.error();
    manifests_.emplace_front(file, bytes->size(), chunk_digests(*bytes));
    if (manifests_.size() > limits::uploads_max) manifests_.pop_back();
    return manifests_.front();
}

Result<std::vector<std::byte>> FileStore::chunk(const Digest& file, std::uint32_t index) const {
    const auto opened = disk_.open(path(file), DiskOpen::existing);
    if (!opened && opened.error().code == ErrorCode::bad_input) return bad_input("there is no file " + file.hex());
    if (!opened) return opened.error();
    std::vector<std::byte> bytes(limits::chunk_bytes);
    const auto have = (*opened)->read(index * std::uint64_t{limits::chunk_bytes}, bytes);
    if (!have) return have.error();
    if (*have == 0 && index > 0) return bad_input("file " + file.hex() + " has no chunk " + std::to_string(index));
    bytes.resize(*have);
    return bytes;
}

Result<void> FileStore::remove(const Digest& file) {
    std::erase_if(manifests_, [&](const wire::FileManifest& manifest) { return manifest.file == file; });
    return disk_.remove(path(file));
}

Result<std::uint64_t> FileStore::remove_others(const std::set<Digest>& kept) {
    const auto names = disk_.list(folder_);
    if (!names) return names.error();
    std::uint64_t removed = 0;
    for (const std::string& name : *names) {
        const auto file = Digest::from_hex(name);
        if (!file || kept.contains(*file)) continue;
        if (const auto gone = remove(*file); !gone) return gone.error();
        ++removed;
    }
    return removed;
}

wire::Message FileStore::answer(const wire::ManifestRequest& request) {
    auto found = manifest(request.file);
    if (!found) return wire::Refusal(wire::RefusalReason::no_such_file, found.error().sentence, request.file);
    return wire::Manifest(std::move(*found));
}

wire::Message FileStore::answer(const wire::ChunkRequest& request) const {
    auto bytes = chunk(request.file, request.index);
    if (!bytes) return wire::Refusal(wire::RefusalReason::no_such_file, bytes.error().sentence, request.file);
    return wire::Chunk(request.file, request.index, std::move(*bytes));
}

}  // namespace lumenfarm
