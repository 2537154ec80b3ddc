#include "master/learned_cut.h"

#include "common/solution/hit_work.h"

#include <utility>

namespace lumenfarm {

LearnedCut learn_cut(const PreparedJob& prepared, const Partition& cut, std::span<const TexelSums> texels) {
    const Box& root = prepared.subspaces->root();
    const auto hits = hit_work(prepared.scene, prepared.layout, texels);
    // the subspaces that the job began with stand for the weights of the octree
    std::vector<SpreadWork> planned;
    for (const Subspace& subspace : prepared.subspaces->all()) planned.push_back({subspace.box, subspace.weight});
    const auto subspaces = static_cast<std::uint32_t>(planned.size());
    const Subspaces learned = Subspaces::cut(root, corrected_work(std::move(planned), hits), subspaces);
    return {{imbalance(Subspaces::of(root, cut).shares(hits)), imbalance(learned.shares(hits))}, learned.partition()};
}

}  // namespace lumenfarm
