#pragma once

#include "common/octree/subspaces.h"
#include "common/solution/run_folder.h"

#include <boost/json/array.hpp>

#include <cstdint>
#include <string>
#include <vector>

/// What `inspect --octree` shows of subspaces: how evenly a cut shares out the work that a result has measured.
namespace lumenfarm {

struct CutBalance {
    std::string name;
    std::vector<double> planned;   ///< of each subspace: what it was cut by, as a share of all
    std::vector<double> measured;  ///< the hits in it, as a share of all
};

/// Cuts in `count` subspaces: unweighted (equal volumes), planned (by the weighted octree, as a job begins), learned
/// (by the hits of this result, too). REQUIRES: 0 < count <= Subspaces::most().
std::vector<CutBalance> balance_of_cuts(const LoadedRun& run, const WeightedOctree& octree, std::uint32_t count);

boost::json::array cuts_document(const std::vector<CutBalance>& cuts);
std::string cuts_table(const std::vector<CutBalance>& cuts);

}  // namespace lumenfarm
