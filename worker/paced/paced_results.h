#pragma once

#include "common/solution/solution.h"
#include "common/support/result.h"
#include "worker/job_context.h"
#include "worker/paced/scratch_maps.h"
#include "worker/paced/stored_hits.h"
#include "worker/parcel.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// Results of any set of a job without tracing it: particle i of a light stands for i modulo the number that is stored.
/// So they are a pure function of the set, they add up as true ones do, and a job of no more particles than are stored
/// has its true result.
namespace lumenfarm::worker {

class PacedResults {
public:
    /// Reads `file`, or traces and writes it when it is not there. `isa` as in TracerScene::make. Errors: bad_input (a
    /// scene or job that can't be, keeps hits or is of strategy subspaces; more lights or texels than fit; a file of
    /// another job), failed, no_space.
    static Result<std::shared_ptr<const PacedResults>> make(std::span<const std::byte> scene_bytes, const JobSpec& spec,
                                                            const std::filesystem::path& file, const std::string& isa);

    /// Errors: bad_input, when the job's hits are not those that are stored, or its texels others.
    Result<std::shared_ptr<const JobContext>> context_of(const wire::JobInfo& info) const;

    /// On average over the light.
    double hits_per_particle(std::uint32_t light) const { return hits_per_particle_[light]; }
    std::uint64_t stored_particles() const { return stored_.particles(); }
    /// The hits of a range. Quick where it begins and ends with blocks of the stored hits; the rest is traced.
    void add_hits(const ParticleRange& range, Parcel& parcel) const;
    /// The sums of ranges, as a result of packing maps has them.
    void add_sums(std::span<const wire::Claim> claims, Parcel& parcel) const;

private:
    struct Sums {
        LightMap map;
        EnergyBalance balance;
    };
    /// How many times sums of stored particles are to be added: by light and place in sums_.
    using Terms = std::map<std::pair<std::uint32_t, std::size_t>, std::int64_t>;
    PacedResults(StoredJob job, std::shared_ptr<const SceneContext> scene, StoredHits stored);
    Result<void> add_up(const JobSpec& spec);
    /// Calls what it is given with the hits of the stored particles [first, end) of a light, in pieces.
    template <class Take>
    void for_pieces(std::uint32_t light, std::uint64_t first, std::uint64_t end, const Take& take) const;
    /// Calls what it is given with stretches [first, end) of stored particles that stand for the range in turn.
    template <class Take>
    void for_stretches(const ParticleRange& range, const Take& take) const;
    void add_stored(std::uint32_t light, std::uint64_t first, std::uint64_t end, LightMap& map, EnergyBalance& balance,
                    Terms& terms) const;

    StoredJob job_;
    std::shared_ptr<const SceneContext> scene_;
    StoredHits stored_;
    std::vector<double> hits_per_particle_;   ///< by light
    std::shared_ptr<const JobContext> maps_;  ///< a job of packing maps
    std::unique_ptr<ScratchMaps> scratch_;
    std::uint64_t step_ = 0;               ///< particles between two of sums_; a multiple of a block
    std::vector<std::vector<Sums>> sums_;  ///< by light: of its stored particles before 0, step_, 2 step_ ...
};

}  // namespace lumenfarm::worker
