#pragma once

#include "common/support/result.h"
#include "proto/messages.h"
#include "worker/discard.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

/// Fetches one scene from the master, chunk by chunk, in order, each verified by its digest.
namespace lumenfarm::worker {

class SceneFetch {
public:
    SceneFetch(const Digest& scene, std::uint64_t bytes_expected) : scene_(scene), bytes_expected_(bytes_expected) {}

    /// What to ask for at the start of a session: chunks that have arrived before are kept.
    std::vector<wire::Message> begin_session();
    // What is not asked for is dropped, and dropped() says why.
    /// Errors: failed, when the manifest is not the scene's.
    Result<std::vector<wire::Message>> on_manifest(const wire::Manifest& manifest);
    /// Errors: failed, when a chunk was damaged limits::chunk_attempts_max times in a row, or the whole differs.
    Result<std::vector<wire::Message>> on_chunk(const wire::Chunk& chunk);

    const Digest& scene() const { return scene_; }
    /// Why the last message was of no use, unless it was.
    const std::optional<Discard>& dropped() const { return dropped_; }
    /// The whole scene, verified; null until then.
    std::shared_ptr<const std::vector<std::byte>> complete() const { return complete_; }

private:
    std::vector<wire::Message> ask();

    Digest scene_;
    std::uint64_t bytes_expected_;
    std::optional<wire::FileManifest> manifest_;
    std::vector<std::byte> bytes_;
    std::size_t received_ = 0;  ///< chunks in bytes_
    std::size_t asked_ = 0;     ///< chunks asked for in this session, from the first on
    std::uint32_t damaged_ = 0;
    std::optional<Discard> dropped_;
    std::shared_ptr<const std::vector<std::byte>> complete_;
};

}  // namespace lumenfarm::worker
