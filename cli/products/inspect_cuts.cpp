#include "cli/products/inspect_cuts.h"

#include "common/solution/hit_work.h"

#include <boost/json.hpp>

#include <iomanip>
#include <numeric>
#include <sstream>
#include <utility>

namespace lumenfarm {
namespace {

namespace json = boost::json;

std::vector<double> as_shares(std::vector<double> work) {
    const double sum = std::accumulate(work.begin(), work.end(), 0.0);
    for (double& each : work) each = sum > 0 ? each / sum : 0;
    return work;
}

CutBalance balance(std::string name, const Subspaces& cut, const std::vector<SpreadWork>& hits) {
    CutBalance balance{std::move(name), {}, as_shares(cut.shares(hits))};
    for (const Subspace& subspace : cut.all()) balance.planned.push_back(subspace.weight);
    balance.planned = as_shares(std::move(balance.planned));
    return balance;
}

json::array numbers(const std::vector<double>& values) { return json::array(values.begin(), values.end()); }

}  // namespace

std::vector<CutBalance> balance_of_cuts(const LoadedRun& run, const WeightedOctree& octree, std::uint32_t count) {
    const Box root = octree.octree().box(Octree::root());
    const auto hits = hit_work(run.scene, run.layout, run.solution.texels);
    return {balance("unweighted", Subspaces::cut(root, {{root, 1}}, count), hits),
            balance("planned", Subspaces::cut(root, planned_work(octree), count), hits),
            balance("learned", Subspaces::cut(root, corrected_work(planned_work(octree), hits), count), hits)};
}

json::array cuts_document(const std::vector<CutBalance>& cuts) {
    json::array all;
    for (const CutBalance& cut : cuts)
        all.push_back(json::object{{"cut", cut.name},
                                   {"largest_planned_over_mean", imbalance(cut.planned)},
                                   {"largest_measured_over_mean", imbalance(cut.measured)},
                                   {"planned", numbers(cut.planned)},
                                   {"measured", numbers(cut.measured)}});
    return all;
}

std::string cuts_table(const std::vector<CutBalance>& cuts) {
    std::ostringstream text;
    text << "subspaces  " << cuts.front().planned.size()
         << "; the largest share of what they are cut by, and of the hits, "
         << "over the mean:\n";
    for (const CutBalance& cut : cuts)
        text << "  " << std::left << std::setw(12) << cut.name << std::right << std::fixed << std::setprecision(3)
             << std::setw(9) << imbalance(cut.planned) << std::setw(9) << imbalance(cut.measured) << "\n";
    return text.str();
}

}  // namespace lumenfarm
