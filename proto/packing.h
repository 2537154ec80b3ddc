#pragma once

#include "common/scene/scene.h"
#include "common/solution/solution.h"
#include "proto/messages_result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Both packings of hits, from what a worker holds to result parts and back. The sums that come out are the same to the
/// bit, since every part only adds integers.
namespace lumenfarm::wire {

/// `records`: hits of one light in messages of `hits_per_message`. Sequences count up from `first`. `energies`: empty
/// or one a record. REQUIRES: 1 <= hits_per_message <= limits::hits_per_message_max.
std::vector<ResultHits> pack_hits(const PartId& first, std::uint32_t light, std::span<const HitRecord> records,
                                  std::span<const std::uint32_t> energies, std::uint32_t hits_per_message);

/// `maps`: the sums that are not zero. REQUIRES: at most limits::hits_per_map_max hits.
std::vector<ResultMap> pack_map(const PartId& first, std::span<const TexelSums> texels,
                                std::span<const SurfaceBatches> surfaces);

std::vector<ResultKept> pack_kept(const PartId& first, std::span<const KeptHit> hits);

/// Whether a part may be merged into a job of this scene: every index exists and every sum is one that its hits can
/// have, so that adding it is safe whoever sent it. `lights`, `texels`, `surfaces`: how many there are.
bool valid_hits(const ResultHits& part, const Scene& scene, Absorption absorption);
bool valid_map(const ResultMap& part, std::uint64_t texels, std::size_t surfaces);
bool valid_kept(const ResultKept& part, const Scene& scene);

/// Adds a part to dense sums. REQUIRES: valid_map().
void add_map(const ResultMap& part, std::span<TexelSums> texels, std::span<SurfaceBatches> surfaces);

/// Hits in a part as its texels and as its surfaces count them; over a whole result both equal EnergyBalance::hits.
struct HitCounts {
    std::uint64_t by_texel = 0;
    std::uint64_t by_surface = 0;
    HitCounts& operator+=(const HitCounts& other);
    bool operator==(const HitCounts&) const = default;
};
HitCounts hits_of(const ResultHits& part);
HitCounts hits_of(const ResultMap& part);

}  // namespace lumenfarm::wire
