#pragma once

#include "common/solution/cut_learning.h"
#include "common/solution/solution.h"
#include "master/recovered_job.h"

#include <span>

namespace lumenfarm {

/// The cut in subspaces, corrected by what was measured of the job. Of the cut that the job began with only hits count,
/// of later ones also the time: what was taken in the very uneven subspaces of a plan says little of the smaller ones
/// to come. A cut that is not more uneven than `above` stays. REQUIRES: the job has subspaces, `cut` as many; `texels`
/// is of its layout.
LearnedCut learn_cut(const PreparedJob& prepared, const Partition& cut, std::span<const TexelSums> texels,
                     const WorkTimes& known, double above);

}  // namespace lumenfarm
