#pragma once

#include "common/scene/job_spec.h"
#include "common/support/digest.h"
#include "common/support/limits.h"
#include "common/support/result.h"
#include "common/transport/tracer.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

/// The hits of the first particles of each light of a job: traced once, kept on disk.
namespace lumenfarm::worker {

/// What the hits depend on.
struct StoredJob {
    Digest scene;
    JobSpec spec;
};

/// Whether the paths of particles are the same in both.
bool same_paths(const JobSpec& a, const JobSpec& b);

class StoredHits {
public:
    static constexpr std::uint64_t block_particles = 64;
    static constexpr std::size_t lights_max = 512;

    // REQUIRES of both: at most lights_max lights.
    static StoredHits trace(const TracerScene& tracer, const StoredJob& job);
    /// Errors: bad_input (damaged, or of another job), failed.
    static Result<StoredHits> read(const std::filesystem::path& file, const TracerScene& tracer, const StoredJob& job);
    /// Errors: no_space, failed.
    Result<void> write(const std::filesystem::path& file, const StoredJob& job) const;

    /// How many particles of each light are stored: a power of two, and a multiple of what batch_of() repeats after.
    std::uint64_t particles() const { return blocks_.front().size() * block_particles; }
    /// Hits of the particles [block * block_particles, (block + 1) * block_particles) of a light.
    const TracedHits& block(std::uint32_t light, std::uint64_t block) const { return blocks_[light][block]; }

    bool operator==(const StoredHits& other) const;

private:
    std::vector<std::vector<TracedHits>> blocks_;  ///< by light
};

}  // namespace lumenfarm::worker
