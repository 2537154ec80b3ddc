#include "common/net/file_transfer.h"

#include "common/scene/scene_file.h"

#include <algorithm>
#include <string>

namespace lumenfarm::net {
namespace {

Result<wire::FileManifest> fetch_manifest(BlockingClient& client, const Digest& file, std::uint64_t bytes_max) {
    auto reply = client.ask_for<wire::Manifest>(wire::ManifestRequest(file));
    if (!reply) return reply.error();
    auto& manifest = reply->manifest;
    if (manifest.file != file) return failed("the master answered with another file than " + file.hex());
    if (manifest.total_bytes > bytes_max)
        return failed("file " + file.hex() + " has " + std::to_string(manifest.total_bytes) + " bytes, more than the " +
                      std::to_string(bytes_max) + " that are allowed");
    return std::move(manifest);
}

Result<std::vector<std::byte>> fetch_chunk(BlockingClient& client, const wire::FileManifest& manifest,
                                           std::uint32_t index) {
    auto chunk = client.ask_for<wire::Chunk>(wire::ChunkRequest(manifest.file, index));
    if (!chunk) return chunk.error();
    const bool right = chunk->file == manifest.file && chunk->index == index &&
                       chunk->bytes.size() == manifest.bytes_of_chunk(index) &&
                       sha256(chunk->bytes) == manifest.chunks[index];
    if (!right) return failed("chunk " + std::to_string(index) + " of file " + manifest.file.hex() + " came damaged");
    return std::move(chunk->bytes);
}

std::span<const std::byte> chunk_of(std::span<const std::byte> bytes, std::uint64_t index) {
    const auto begin = index * limits::chunk_bytes;
    return bytes.subspan(begin, std::min(limits::chunk_bytes, bytes.size() - begin));
}

Result<void> upload(BlockingClient& client, const wire::FileManifest& manifest, std::span<const std::byte> bytes,
                    const std::vector<std::uint32_t>& missing) {
    for (const auto index : missing) {
        if (index >= manifest.chunks.size())
            return failed("the master asks for chunk " + std::to_string(index) + " of a scene that has fewer");
        const auto chunk = chunk_of(bytes, index);
        const auto sent = client.tell(wire::Chunk(manifest.file, index, {chunk.begin(), chunk.end()}));
        if (!sent) return sent;
    }
    return {};
}

}  // namespace

Result<void> fetch_file(BlockingClient& client, const Digest& file, std::uint64_t bytes_max, const FileSink& sink) {
    const auto manifest = fetch_manifest(client, file, bytes_max);
    if (!manifest) return manifest.error();
    Sha256 whole;
    for (std::uint32_t index = 0; index < manifest->chunks.size(); ++index) {
        const auto bytes = fetch_chunk(client, *manifest, index);
        if (!bytes) return bytes.error();
        whole.update(*bytes);
        const auto taken = sink(*bytes);
        if (!taken) return taken;
    }
    if (whole.finish() != file) return failed("file " + file.hex() + " came damaged");
    return {};
}

Result<std::vector<std::byte>> fetch_file(BlockingClient& client, const Digest& file, std::uint64_t bytes_max) {
    std::vector<std::byte> all;
    const auto fetched = fetch_file(client, file, bytes_max, [&](std::span<const std::byte> bytes) -> Result<void> {
        all.insert(all.end(), bytes.begin(), bytes.end());
        return {};
    });
    if (!fetched) return fetched.error();
    return all;
}

Result<std::uint64_t> submit_job(BlockingClient& client, std::uint64_t key, const JobSpec& spec,
                                 std::span<const std::byte> scene_bytes) {
    if (scene_bytes.size() > limits::scene_bytes_max)
        return bad_input("the compiled scene has " + std::to_string(scene_bytes.size()) + " bytes, more than the " +
                         std::to_string(limits::scene_bytes_max) + " that a farm takes");
    const wire::FileManifest manifest(sha256(scene_bytes), scene_bytes.size(), chunk_digests(scene_bytes));
    const wire::Submit submit(key, spec, manifest);
    // Once to learn what is missing, once more to start; a chunk damaged on the way is asked for again.
    constexpr int rounds = 3;
    for (int round = 0; round < rounds; ++round) {
        const auto reply = client.ask_for<wire::SubmitReply>(submit, limits::submit_seconds);
        if (!reply) return reply.error();
        if (reply->job != 0) return reply->job;
        const auto uploaded = upload(client, manifest, scene_bytes, reply->missing);
        if (!uploaded) return uploaded.error();
    }
    return failed("the master still lacks parts of the scene after they were sent");
}

}  // namespace lumenfarm::net
