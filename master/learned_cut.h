#pragma once

#include "common/octree/partition.h"
#include "common/solution/hit_work.h"
#include "master/recovered_job.h"

#include <span>

/// The cut in subspaces, corrected by what was measured of the job (docs/subspaces.md).
namespace lumenfarm {

struct LearnedCut {
    Evenness evenness;
    Partition cut;
};

/// Of the cut that the job began with only hits count, of later ones also `costs`, by subspace: what was taken in the
/// very uneven subspaces of a plan says little of the smaller ones to come. REQUIRES: the job has subspaces, `cut` as
/// many; `texels` is of its layout.
LearnedCut learn_cut(const PreparedJob& prepared, const Partition& cut, std::span<const TexelSums> texels,
                     std::span<const SubspaceCost> costs);

}  // namespace lumenfarm
