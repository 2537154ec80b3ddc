#pragma once

#include "common/support/digest.h"
#include "common/support/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

/// Compiled scenes on disk: FOLDER/<64 hex digits>. Several workers may share a folder.
namespace lumenfarm::worker {

class SceneCache {
public:
    /// `bytes_max`: of all files together; the ones that were used longest ago go first.
    SceneCache(std::filesystem::path folder, std::uint64_t bytes_max)
        : folder_(std::move(folder)), bytes_max_(bytes_max) {}

    /// Null when the scene is not here. Errors: failed, damaged: then its file is removed.
    Result<std::shared_ptr<const std::vector<std::byte>>> load(const Digest& scene) const;
    /// Gives the scenes that had to go. Errors: failed (disk), bad_input (larger than the cache). The cache works on
    /// without the scene.
    Result<std::vector<Digest>> keep(const Digest& scene, std::span<const std::byte> bytes) const;

private:
    std::vector<Digest> make_room(std::uint64_t bytes) const;

    std::filesystem::path folder_;
    std::uint64_t bytes_max_;
};

/// $XDG_CACHE_HOME/lumenfarm, or /var/cache/lumenfarm.
std::filesystem::path default_cache_folder();

}  // namespace lumenfarm::worker
