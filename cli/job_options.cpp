#include "cli/job_options.h"

#include "cli/number.h"
#include "cli/options.h"

namespace lumenfarm {
namespace {

constexpr const char* group = "Job options";

void declare_result_options(CLI::App& app, JobSpec& spec) {
    count_option(app, "--particles", spec.particles, "Particles of all lights together: more of them, less noise")
        ->group(group);
    real_option(app, "--texel", spec.texel_m,
                "Edge of a texel of the light maps; 0 chooses 1/64 of the scene's diagonal")
        ->type_name("METRES")
        ->group(group);
    count_option(app, "--keep-hits", spec.keep_hits, "Hits to keep, for sharper pictures and measurements")
        ->group(group);
}

void declare_way_options(CLI::App& app, JobSpec& spec) {
    choice_option<Strategy>(app, "--strategy", spec.strategy, {{"sets", Strategy::sets}},
                            "How the work is shared out: sets of particles")
        ->group(group);
    choice_option<Packing>(app, "--packing", spec.packing,
                           {{"auto", Packing::automatic}, {"records", Packing::records}, {"maps", Packing::maps}},
                           "How results travel: each hit, or sums; what comes out is the same")
        ->group(group);
    option_detail::declare(app, "--particles-per-set", "auto|N", "auto", "Particles in one unit of work",
                           [&spec](const std::string& text) -> std::string {
                               if (text == "auto") {
                                   spec.particles_per_set = 0;
                                   return {};
                               }
                               const auto count = parse_count(text);
                               if (!count) return count.error().sentence;
                               if (*count == 0) return "'" + text + "' particles make no set; say auto or a number";
                               spec.particles_per_set = *count;
                               return {};
                           })
        ->group(group);
    count_option(app, "--hits-per-message", spec.hits_per_message, "Hits in one message, when each hit travels")
        ->group(group);
    text_option(app, "--name", spec.name, "The job's name in lists; the scene's file name if none is given")
        ->group(group);
    signed_option(app, "--priority", spec.priority, "Jobs of higher priority get work first")->group(group);
}

}  // namespace

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
