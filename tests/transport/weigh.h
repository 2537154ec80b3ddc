#pragma once

#include "common/octree/weighted_octree.h"
#include "common/transport/emission.h"

#include <vector>

namespace lumenfarm::testing {

inline WeightedOctree weigh(const Scene& scene) {
    std::vector<double> shares;
    for (const LightEmission& light : make_emission(scene).value().lights) shares.push_back(light.share);
    return make_weighted_octree(scene, {}, shares);
}

}  // namespace lumenfarm::testing
