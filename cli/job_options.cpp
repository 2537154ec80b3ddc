#include "cli/job_options.h"

#include "cli/number.h"
#include "cli/options.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <string>

namespace lumenfarm {
namespace {

constexpr const char* group = "Job options";

/// 0 stands for `auto`. `why_not_zero`: the rest of the sentence about 0.
void automatic_count_option(CLI::App& app, const char* name, const char* text, const std::string& why_not_zero,
                            std::function<void(std::uint64_t)> take) {
    option_detail::declare(app, name, "auto|N", "auto", text, [=](const std::string& given) -> std::string {
        if (given == "auto") {
            take(0);
            return {};
        }
        const auto count = parse_count(given);
        if (!count) return count.error().sentence;
        if (*count == 0) return "'" + given + "' " + why_not_zero + "; say auto or a number";
        take(*count);
        return {};
    })->group(group);
}

void declare_result_options(CLI::App& app, JobSpec& spec) {
    count_option(app, "--particles", spec.particles, "Particles of all lights together: more of them, less noise")
        ->group(group);
    declare_texel_option(app, spec);
    count_option(app, "--keep-hits", spec.keep_hits, "Hits to keep, for sharper pictures and measurements")
        ->group(group);
}

}  // namespace

void declare_texel_option(CLI::App& app, JobSpec& spec) {
    real_option(app, "--texel", spec.texel_m,
                "Edge of a texel of the light maps; 0 chooses 1/64 of the scene's diagonal")
        ->type_name("METRES")
        ->group(group);
}

void declare_packing_option(CLI::App& app, JobSpec& spec) {
    choice_option<Packing>(app, "--packing", spec.packing,
                           {{"auto", Packing::automatic}, {"records", Packing::records}, {"maps", Packing::maps}},
                           "How results travel: each hit, or sums; what comes out is the same")
        ->group(group);
}

void declare_way_options(CLI::App& app, JobSpec& spec) {
    choice_option<Strategy>(app, "--strategy", spec.strategy,
                            {{"sets", Strategy::sets}, {"subspaces", Strategy::subspaces}},
                            "How the work is shared out: by particles, or by space, for scenes larger than a worker's "
                            "memory; what comes out is the same")
        ->group(group);
    automatic_count_option(app, "--subspaces", "With subspaces: into how many the scene is cut", "cut no scene",
                           [&spec](std::uint64_t count) {
                               constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
                               spec.subspaces = static_cast<std::uint32_t>(std::min(count, most));  // refused later
                           });
    declare_packing_option(app, spec);
    automatic_count_option(app, "--particles-per-set", "Particles in one unit of work", "particles make no set",
                           [&spec](std::uint64_t count) { spec.particles_per_set = count; });
    count_option(app, "--hits-per-message", spec.hits_per_message, "Hits, or particles in flight, in one message")
        ->group(group);
    text_option(app, "--name", spec.name, "The job's name in lists; the scene's file name if none is given")
        ->group(group);
    signed_option(app, "--priority", spec.priority, "Jobs of higher priority get work first")->group(group);
}

void declare_path_options(CLI::App& app, JobSpec& spec) {
    count_option(app, "--seed", spec.seed, "Another seed gives other noise")->group(group);
    choice_option<Absorption>(app, "--absorption", spec.absorption,
                              {{"analog", Absorption::analog}, {"attenuate", Absorption::attenuate}},
                              "Surfaces absorb whole particles, or a part of each particle's energy")
        ->group(group);
    real_option(app, "--cutoff", spec.cutoff, "With attenuate: the fraction of its energy at which a path is ended")
        ->group(group);
    choice_option<CutoffRule>(app, "--cutoff-rule", spec.cutoff_rule,
                              {{"roulette", CutoffRule::roulette}, {"plain", CutoffRule::plain}},
                              "With attenuate: end such paths by chance (exact on average) or always")
        ->group(group);
}

void declare_job_options(CLI::App& app, JobSpec& spec) {
    declare_result_options(app, spec);
    declare_path_options(app, spec);
    declare_way_options(app, spec);
}

}  // namespace lumenfarm
