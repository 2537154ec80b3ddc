#pragma once

#include "common/transport/tracer.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <tuple>
#include <vector>

namespace lumenfarm::testing {

using HitKey = std::tuple<std::uint64_t, std::uint64_t, std::uint32_t>;

/// Records (and energies) as a sorted list: what was hit, whatever the order.
inline std::vector<HitKey> sorted(const TracedHits& hits) {
    std::vector<HitKey> keys;
    for (std::size_t i = 0; i < hits.records.size(); ++i) {
        std::uint64_t words[2];
        std::memcpy(words, &hits.records[i], sizeof words);
        keys.emplace_back(words[0], words[1], hits.energies.empty() ? 0 : hits.energies[i]);
    }
    std::sort(keys.begin(), keys.end());
    return keys;
}

}  // namespace lumenfarm::testing
