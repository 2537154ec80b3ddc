#pragma once

#include "common/support/result.h"

#include <cstdint>
#include <string>
#include <string_view>

/// What a user asks for. The first group decides the result (law 1); the second only how it is computed.
namespace lumenfarm {

enum class Absorption : std::uint8_t { analog, attenuate };
enum class CutoffRule : std::uint8_t { roulette, plain };
enum class Strategy : std::uint8_t { sets, subspaces };
enum class Packing : std::uint8_t { automatic, records, maps };
std::string_view name_of(Packing packing);  ///< as on the command line

struct JobSpec {
    std::uint64_t particles = 1'000'000;  ///< all lights together, in proportion to their flux
    std::uint64_t seed = 1;
    Absorption absorption = Absorption::analog;
    CutoffRule cutoff_rule = CutoffRule::roulette;
    double cutoff = 0.01;         ///< attenuate: fraction of the start energy under which roulette or cut-off acts
    double texel_m = 0;           ///< edge of a texel [m]; 0 chooses from the size of the scene
    std::uint64_t keep_hits = 0;  ///< hits kept for nearest-neighbour estimates

    Strategy strategy = Strategy::sets;
    std::uint32_t subspaces = 0;  ///< strategy subspaces: into how many the scene is cut; 0 is automatic
    Packing packing = Packing::automatic;
    std::uint64_t particles_per_set = 0;     ///< 0 is automatic
    std::uint32_t hits_per_message = 5'000;  ///< and particles in flight
    std::string name;
    std::int32_t priority = 0;
    bool operator==(const JobSpec&) const = default;
};

/// Errors: bad_input names the option and its value.
Result<void> validate(const JobSpec& spec);

/// Whether the one is the other with more particles, or fewer.
bool same_but_for_particles(const JobSpec& a, JobSpec b);

/// The texel edge in force: spec.texel_m, or 1/64 of the diagonal of the scene's bounding box.
double texel_in_force_m(const JobSpec& spec, double scene_diagonal_m);

}  // namespace lumenfarm
