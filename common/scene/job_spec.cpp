#include "common/scene/job_spec.h"

#include "common/scene/text.h"
#include "common/support/limits.h"

#include <cmath>

namespace lumenfarm {
namespace {

template <class T>
Error refused(const char* option, T value, const std::string& allowed) {
    return bad_input(std::string(option) + " is " + std::to_string(value) + "; it must be " + allowed);
}

std::string range(std::uint64_t low, std::uint64_t high) {
    return "from " + std::to_string(low) + " to " + std::to_string(high);
}

Result<void> validate_result_group(const JobSpec& spec) {
    if (spec.particles < 1 || spec.particles > limits::particles_max)
        return refused("particles", spec.particles, range(1, limits::particles_max));
    if (spec.absorption > Absorption::attenuate)
        return refused("absorption", static_cast<int>(spec.absorption), "analog (0) or attenuate (1)");
    if (spec.cutoff_rule > CutoffRule::plain)
        return refused("cutoff rule", static_cast<int>(spec.cutoff_rule), "roulette (0) or plain (1)");
    if (!(spec.cutoff > 0 && spec.cutoff < 1)) return refused("cutoff", spec.cutoff, "above 0 and below 1");
    if (!(spec.texel_m >= 0 && spec.texel_m <= limits::coordinate_max_m))
        return refused("texel", spec.texel_m, "0 (automatic) or a length in metres up to 1e7");
    if (spec.keep_hits > limits::kept_hits_max)
        return refused("keep-hits", spec.keep_hits, range(0, limits::kept_hits_max));
    return {};
}

Result<void> validate_way_group(const JobSpec& spec) {
    if (spec.strategy > Strategy::subspaces)
        return refused("strategy", static_cast<int>(spec.strategy), "sets (0) or subspaces (1)");
    if (spec.subspaces > limits::subspaces_max)
        return refused("subspaces", spec.subspaces, range(0, limits::subspaces_max));
    if (spec.packing > Packing::maps)
        return refused("packing", static_cast<int>(spec.packing), "auto (0), records (1) or maps (2)");
    if (spec.particles_per_set > limits::particles_per_set_max)
        return refused("particles-per-set", spec.particles_per_set, range(0, limits::particles_per_set_max));
    if (spec.hits_per_message < 1 || spec.hits_per_message > limits::hits_per_message_max)
        return refused("hits-per-message", spec.hits_per_message, range(1, limits::hits_per_message_max));
    if (std::abs(std::int64_t{spec.priority}) > limits::priority_max)
        return refused("priority", spec.priority,
                       "from -" + std::to_string(limits::priority_max) + " to " + std::to_string(limits::priority_max));
    if (!is_clean_name(spec.name))
        return bad_input("the job's name '" + clean_name(spec.name) + "' must be UTF-8 text of at most " +
                         std::to_string(limits::name_bytes_max) + " bytes without control characters");
    return {};
}

}  // namespace

std::string_view name_of(Packing packing) {
    switch (packing) {
        case Packing::automatic: return "auto";
        case Packing::records: return "records";
        case Packing::maps: return "maps";
    }
    return "?";
}

Result<void> validate(const JobSpec& spec) {
    if (auto result = validate_result_group(spec); !result) return result;
    return validate_way_group(spec);
}

bool same_but_for_particles(const JobSpec& a, JobSpec b) {
    b.particles = a.particles;
    return a == b;
}

double texel_in_force_m(const JobSpec& spec, double scene_diagonal_m) {
    return spec.texel_m > 0 ? spec.texel_m : scene_diagonal_m / 64;
}

}  // namespace lumenfarm
