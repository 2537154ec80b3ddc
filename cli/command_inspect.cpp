#include "cli/commands.h"
#include "cli/options.h"
#include "cli/products/inspect.h"
#include "cli/products/inspect_octree.h"
#include "cli/products/json_text.h"
#include "common/octree/weighted_octree.h"
#include "common/solution/run_folder.h"

/// `inspect`: what a result holds.
namespace lumenfarm {
namespace {

OctreeSummary octree_of(const LoadedRun& run) {
    std::vector<double> shares;
    for (const auto& light : run.emission.lights) shares.push_back(light.share);
    return summarize(run.scene, make_weighted_octree(run.scene, OctreeOptions(), shares));
}

class InspectCommand : public Command {
public:
    explicit InspectCommand(CLI::App& app)
        : Command(app, "inspect", "Show a result: digest, energy balance, light on each surface") {
        app_.add_option("DIR", path_, "The results' folder, or the solution.lfs in it")->type_name("")->required();
        flag_option(app_, "--json", json_, "Print one JSON document");
        flag_option(app_, "--octree", octree_, "Show the weighted octree, too");
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
        if (octree_) document["octree"] = octree_document(octree_of(run));
        return json_text(document);
    }
    std::string table(const LoadedRun& run) const {
        return octree_ ? inspect_table(run) + "\n" + octree_table(octree_of(run)) : inspect_table(run);
    }

    std::string path_;
    bool json_ = false;
    bool octree_ = false;
};

}  // namespace

std::unique_ptr<Command> make_inspect_command(CLI::App& app) { return std::make_unique<InspectCommand>(app); }

}  // namespace lumenfarm
