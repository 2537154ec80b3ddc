#pragma once

#include "common/octree/subspaces.h"
#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/solution/solution.h"
#include "common/solution/texel_layout.h"
#include "common/support/result.h"
#include "common/transport/emission.h"
#include "proto/messages.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// What the master knows of a job beside its sums.
namespace lumenfarm {

using JobId = std::uint64_t;  ///< 1, 2, ... in the order of submission

/// The scene of a job made ready for committing hits. Read-only, made off the core by prepare_job().
struct PreparedJob {
    Scene scene;
    Emission emission;
    TexelLayout layout;
    double texel_m = 0;                    ///< in force
    std::vector<std::uint64_t> particles;  ///< of each light
    std::vector<double> light_costs;       ///< of a particle of each light, as the octree predicts; their mean is 1
    std::optional<Subspaces> subspaces;    ///< strategy subspaces
    std::string octree;                    ///< a sentence about the weighted octree, for the log

    /// Where work comes from: the lights, and behind them the subspaces.
    std::size_t sources() const { return particles.size() + (subspaces ? subspaces->all().size() : 0); }
};

/// Decodes the scene and derives all that a job of this spec needs. Errors: bad_input (damaged scene, no light, too
/// many texels, more subspaces than the octree has) with a sentence for the submitter.
Result<std::shared_ptr<const PreparedJob>> prepare_job(const JobSpec& spec, std::span<const std::byte> scene_bytes);

/// The packing in force. `maps` needs the dense sums to fit limits::map_bytes_max. Automatic chooses maps where they
/// fit and a job has at least two particles a texel, so that maps are the smaller traffic; records otherwise. The
/// result is the same to the bit.
Packing packing_in_force(const JobSpec& spec, const PreparedJob& prepared);

/// What the job store keeps of a job.
struct JobRecord {
    std::uint64_t key = 0;  ///< of the submitter: the same key is the same job
    JobSpec spec;
    std::uint64_t scene_bytes = 0;
    wire::JobStatus status;
    Digest solution_file;  ///< valid when has_solution
    bool has_solution = false;
    bool complete = false;             ///< the solution holds every particle
    bool flights_lost = false;         ///< it ended with particles in flight, which the solution books as cut off
    bool cancel_asked = false;         ///< it ends as soon as what is on its way has arrived
    bool paused = false;               ///< it gets no work until somebody resumes it
    bool audited = false;              ///< the disk keeps each result until the job is over
    bool begun = false;                ///< the disk holds what was done of it
    std::vector<std::uint64_t> liars;  ///< machines whose results are to be taken out of it again
    bool distrusted = false;           ///< so are all results
    std::uint64_t solution_bytes = 0;
    std::int64_t ended_unix_seconds = 0;

    JobId id() const { return status.job; }
    bool over() const { return wire::is_over(status.state); }
    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        ar& key& spec& scene_bytes& status& solution_file& has_solution& complete& flights_lost& cancel_asked& paused&
            audited& begun;
        ar& wire::at_most(liars, limits::sessions_max) & distrusted& solution_bytes& ended_unix_seconds;
    }
};

}  // namespace lumenfarm
