#include "worker/scene_fetch.h"

#include "common/scene/scene_file.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::worker {

std::vector<wire::Message> SceneFetch::begin_session() {
    asked_ = received_;
    if (!manifest_) return {wire::ManifestRequest(scene_)};
    return ask();
}

std::vector<wire::Message> SceneFetch::ask() {
    std::vector<wire::Message> requests;
    const std::size_t until = std::min(manifest_->chunks.size(), received_ + limits::chunks_in_flight);
    for (; asked_ < until; ++asked_)
        requests.emplace_back(wire::ChunkRequest(scene_, static_cast<std::uint32_t>(asked_)));
    return requests;
}

Result<std::vector<wire::Message>> SceneFetch::on_manifest(const wire::Manifest& manifest) {
    const bool asked_for = !manifest_ && manifest.manifest.file == scene_;
    dropped_ = asked_for ? std::nullopt : std::optional(Discard::unexpected_message);
    if (dropped_) return std::vector<wire::Message>{};
    if (!manifest.manifest.valid() || manifest.manifest.total_bytes != bytes_expected_)
        return failed("the master's manifest is not of scene " + scene_.hex());
    manifest_ = manifest.manifest;
    return ask();
}

Result<std::vector<wire::Message>> SceneFetch::on_chunk(const wire::Chunk& chunk) {
    const bool asked_for =
        manifest_ && chunk.file == scene_ && chunk.index == received_ && received_ < manifest_->chunks.size();
    dropped_ = asked_for ? std::nullopt : std::optional(Discard::unexpected_message);
    if (dropped_) return std::vector<wire::Message>{};
    if (chunk.bytes.size() != manifest_->bytes_of_chunk(chunk.index) ||
        sha256(chunk.bytes) != manifest_->chunks[chunk.index]) {
        dropped_ = Discard::damaged_chunk;
        if (++damaged_ >= limits::chunk_attempts_max)
            return failed("chunk " + std::to_string(chunk.index) + " of scene " + scene_.hex() + " comes damaged");
        asked_ = received_;
        return ask();
    }
    damaged_ = 0;
    bytes_.insert(bytes_.end(), chunk.bytes.begin(), chunk.bytes.end());
    if (++received_ < manifest_->chunks.size()) return ask();
    if (scene_digest(bytes_) != scene_) return failed("the chunks of scene " + scene_.hex() + " make another scene");
    complete_ = std::make_shared<const std::vector<std::byte>>(std::move(bytes_));
    return std::vector<wire::Message>{};
}

}  // namespace lumenfarm::worker
