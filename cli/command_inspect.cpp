#include "cli/commands.h"
#include "cli/options.h"
#include "cli/products/inspect.h"
#include "cli/products/inspect_cuts.h"
#include "cli/products/inspect_octree.h"
#include "cli/products/json_text.h"
#include "common/octree/weighted_octree.h"
#include "common/solution/run_folder.h"

#include <algorithm>

/// `inspect`: what a result holds.
namespace lumenfarm {
namespace {

WeightedOctree octree_of(const LoadedRun& run) {
    std::vector<double> shares;
    for (const auto& light : run.emission.lights) shares.push_back(light.share);
    return make_weighted_octree(run.scene, OctreeOptions(), shares);
}

/// In as many subspaces as the job had, or would have.
std::vector<CutBalance> cuts_of(const LoadedRun& run, const WeightedOctree& octree) {
    const std::uint32_t wanted = run.solution.spec.subspaces > 0 ? run.solution.spec.subspaces : automatic_subspaces;
    return balance_of_cuts(run, octree,
                           static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, Subspaces::most(octree))));
}

class InspectCommand : public Command {
public:
    explicit InspectCommand(CLI::App& app)
        : Command(app, "inspect", "Show a result: digest, energy balance, light on each surface") {
        app_.add_option("DIR", path_, "The results' folder, or the solution.lfs in it")->type_name("")->required();
        flag_option(app_, "--json", json_, "Print one JSON document");
        flag_option(app_, "--octree", octree_, "Show the weighted octree, and cuts in subspaces, too");
    }

    Result<void> execute(Console& console) override {
        const auto run = load_run(path_);
        if (!run) return run.error();
        console.result(json_ ? document(*run) : table(*run));
        return {};
    }

private:
    std::string document(const LoadedRun& run) const {
        auto document = inspect_document(run);
        if (octree_) {
            const WeightedOctree octree = octree_of(run);
            document["octree"] = octree_document(summarize(run.scene, octree));
            document["cuts"] = cuts_document(cuts_of(run, octree));
        }
        return json_text(document);
    }
    std::string table(const LoadedRun& run) const {
        if (!octree_) return inspect_table(run);
        const WeightedOctree octree = octree_of(run);
        return inspect_table(run) + "\n" + octree_table(summarize(run.scene, octree)) +
               cuts_table(cuts_of(run, octree));
    }

    std::string path_;
    bool json_ = false;
    bool octree_ = false;
};

}  // namespace

std::unique_ptr<Command> make_inspect_command(CLI::App& app) { return std::make_unique<InspectCommand>(app); }

}  // namespace lumenfarm
