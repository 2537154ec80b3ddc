#include "master/disk/file_store.h"

#include "common/scene/scene_file.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <algorithm>
#include <fstream>
#include <system_error>

namespace lumenfarm {

namespace fs = std::filesystem;

Result<void> FileStore::open() {
    if (const auto made = make_folder(folder_); !made) return made.error();
    std::error_code error;
    std::vector<fs::path> stale;
    for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error))
        if (at->path().extension() == ".part") stale.push_back(at->path());
    for (const fs::path& path : stale) fs::remove(path, error);
    if (error) return failed("can't clear the folder '" + folder_.string() + "': " + error.message());
    return {};
}

Result<std::vector<std::uint32_t>> FileStore::missing(const wire::FileManifest& manifest) {
    if (fs::exists(path(manifest.file))) return std::vector<std::uint32_t>{};
    const auto same = [&](const Upload& upload) { return upload.manifest == manifest; };
    auto upload = std::find_if(uploads_.begin(), uploads_.end(), same);
    if (upload == uploads_.end()) {
        if (uploads_.size() >= limits::uploads_max) {
            std::error_code ignored;
            fs::remove(part_path(uploads_.front().manifest.file), ignored);
            uploads_.pop_front();
        }
        if (!std::ofstream(part_path(manifest.file), std::ios::binary | std::ios::trunc))
            return failed("can't write '" + part_path(manifest.file).string() + "'");
        const std::size_t chunks = manifest.chunks.size();
        upload = uploads_.insert(uploads_.end(), Upload{manifest, std::vector<bool>(chunks, false), chunks});
    }
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < upload->received.size(); ++i)
        if (!upload->received[i]) indices.push_back(i);
    return indices;
}

Result<void> FileStore::put_chunk(const wire::Chunk& chunk) {
    const auto of_file = [&](const Upload& upload) { return upload.manifest.file == chunk.file; };
    const auto upload = std::find_if(uploads_.begin(), uploads_.end(), of_file);
    const std::string name = "chunk " + std::to_string(chunk.index) + " of " + chunk.file.hex();
    if (upload == uploads_.end() || chunk.index >= upload->received.size())
        return bad_input(name + " was not asked for");
    if (upload->received[chunk.index]) return {};
    if (chunk.bytes.size() != upload->manifest.bytes_of_chunk(chunk.index) ||
        sha256(chunk.bytes) != upload->manifest.chunks[chunk.index])
        return bad_input(name + " is damaged");
    std::fstream file(part_path(chunk.file), std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(chunk.index * limits::chunk_bytes));
    file.write(reinterpret_cast<const char*>(chunk.bytes.data()), static_cast<std::streamsize>(chunk.bytes.size()));
    file.close();
    if (!file) return failed("can't write '" + part_path(chunk.file).string() + "'");
    upload->received[chunk.index] = true;
    if (--upload->left > 0) return {};
    uploads_.erase(upload);
    return finish(chunk.file);
}

/// The whole is verified before it gets its name. write_file() syncs it.
Result<void> FileStore::finish(const Digest& file) {
    auto bytes = read_file(part_path(file), limits::scene_bytes_max);
    std::error_code ignored;
    fs::remove(part_path(file), ignored);
    if (!bytes) return bytes.error();
    if (sha256(*bytes) != file) return bad_input("the chunks of " + file.hex() + " make another file");
    return write_file(path(file), *bytes);
}

Result<Digest> FileStore::put(std::span<const std::byte> bytes) {
    const Digest file = sha256(bytes);
    if (const auto written = write_file(path(file), bytes); !written) return written.error();
    return file;
}

Result<std::vector<std::byte>> FileStore::read(const Digest& file) const {
    auto bytes = read_file(path(file), limits::solution_bytes_max);
    if (bytes && sha256(*bytes) != file) return failed("'" + path(file).string() + "' is damaged: its digest differs");
    return bytes;
}

Result<wire::FileManifest> FileStore::manifest(const Digest& file) {
    const auto same = [&](const wire::FileManifest& manifest) { return manifest.file == file; };
    if (const auto known = std::find_if(manifests_.begin(), manifests_.end(), same); known != manifests_.end())
        return *known;
    const auto bytes = read(file);
    if (!bytes) return bytes.error();
    manifests_.emplace_front(file, bytes->size(), chunk_digests(*bytes));
    if (manifests_.size() > limits::uploads_max) manifests_.pop_back();
    return manifests_.front();
}

Result<std::vector<std::byte>> FileStore::chunk(const Digest& file, std::uint32_t index) const {
    std::ifstream stream(path(file), std::ios::binary);
    if (!stream) return bad_input("there is no file " + file.hex());
    stream.seekg(static_cast<std::streamoff>(index * std::uint64_t{limits::chunk_bytes}));
    std::vector<std::byte> bytes(limits::chunk_bytes);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(stream.gcount()));
    if (bytes.empty() && index > 0) return bad_input("file " + file.hex() + " has no chunk " + std::to_string(index));
    return bytes;
}

}  // namespace lumenfarm
