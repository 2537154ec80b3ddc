#include "master/learned_cut.h"

#include <utility>

namespace lumenfarm {

LearnedCut learn_cut(const PreparedJob& prepared, const Partition& cut, std::span<const TexelSums> texels,
                     std::span<const SubspaceCost> costs) {
    const Box& root = prepared.subspaces->root();
    const Subspaces now = Subspaces::of(root, cut);
    auto measured = hit_work(prepared.scene, prepared.layout, texels);
    if (cut != prepared.subspaces->partition()) measured = costed_work(std::move(measured), now, costs);
    // the subspaces that the job began with stand for the weights of the octree
    std::vector<SpreadWork> planned;
    for (const Subspace& subspace : prepared.subspaces->all()) planned.push_back({subspace.box, subspace.weight});
    const auto subspaces = static_cast<std::uint32_t>(planned.size());
    const Subspaces learned = Subspaces::cut(root, corrected_work(std::move(planned), measured), subspaces);
    return {{imbalance(now.shares(measured)), imbalance(learned.shares(measured))}, learned.partition()};
}

}  // namespace lumenfarm
