#include "master/learned_cut.h"

#include "common/solution/hit_work.h"

#include <utility>
#include <vector>

namespace lumenfarm {

LearnedCut learn_cut(const PreparedJob& prepared, const Partition& cut, std::span<const TexelSums> texels,
                     const WorkTimes& known, double above) {
    // the subspaces that the job began with stand for the weights of the octree
    std::vector<SpreadWork> planned;
    for (const Subspace& subspace : prepared.subspaces->all()) planned.push_back({subspace.box, subspace.weight});
    const bool is_planned = cut == prepared.subspaces->partition();
    return learn_cut(Subspaces::of(prepared.subspaces->root(), cut), std::move(planned),
                     hit_work(prepared.scene, prepared.layout, texels), is_planned ? WorkTimes{} : known, above);
}

}  // namespace lumenfarm
