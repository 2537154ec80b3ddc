#include "proto/packing.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace lumenfarm::wire {
namespace {

/// The id of the part that follows `before` parts after `first`.
PartId nth_part(const PartId& first, std::size_t before) {
    const auto sequence = first.sequence + before;
    ensure(sequence < limits::parts_per_result_max, "a result has at most parts_per_result_max parts");
    return {first.job, first.result, static_cast<std::uint32_t>(sequence)};
}

template <class T>
std::vector<T> piece(std::span<const T> all, std::size_t begin, std::size_t count) {
    const auto part = all.subspan(begin, std::min(count, all.size() - begin));
    return {part.begin(), part.end()};
}

std::vector<TexelDelta> texel_deltas(std::span<const TexelSums> texels) {
    std::vector<TexelDelta> deltas;
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const auto& sums = texels[i];
        if (sums.hits == 0) continue;
        ensure(sums.hits <= limits::hits_per_map_max, "a map is sent before it holds hits_per_map_max hits");
        deltas.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(sums.hits), sums.radiant, sums.x,
                          sums.y, sums.z, sums.y_squared});
    }
    return deltas;
}
static_assert(limits::hits_per_map_max <= std::numeric_limits<std::uint32_t>::max());

std::vector<SurfaceDelta> surface_deltas(std::span<const SurfaceBatches> surfaces) {
    std::vector<SurfaceDelta> deltas;
    for (std::size_t i = 0; i < surfaces.size(); ++i)
        for (std::uint32_t side_batch = 0; side_batch < 2 * limits::batches; ++side_batch) {
            const auto& sums = surfaces[i][side_batch / limits::batches][side_batch % limits::batches];
            if (sums.hits > 0)
                deltas.push_back({static_cast<std::uint32_t>(i), side_batch, sums.radiant, sums.y, sums.hits});
        }
    return deltas;
}

/// Sums of energy that `hits` hits can have: each carries 0 to energy_ticks_max ticks, and the ratios of XYZ to radiant
/// ticks are under 2 (the CIE functions stay under 1.8), rounded for each hit.
bool radiant_possible(std::int64_t radiant, std::uint64_t hits) {
    return radiant >= 0 && radiant <= static_cast<std::int64_t>(hits * limits::energy_ticks_max);
}
bool xyz_possible(std::int64_t xyz, std::int64_t radiant, std::uint64_t hits) {
    return xyz >= 0 && xyz <= 2 * radiant + static_cast<std::int64_t>(hits);
}

bool delta_possible(const TexelDelta& delta) {
    constexpr std::uint64_t y_max = 2 * limits::energy_ticks_max + 1;
    constexpr std::uint64_t y_squared_max = (y_max >> y_squared_shift) * (y_max >> y_squared_shift);
    const auto xyz = {delta.x, delta.y, delta.z};
    return delta.hits > 0 && delta.hits <= limits::hits_per_map_max && radiant_possible(delta.radiant, delta.hits) &&
           std::ranges::all_of(xyz, [&](auto sum) { return xyz_possible(sum, delta.radiant, delta.hits); }) &&
           delta.y_squared <= delta.hits * y_squared_max;
}

bool delta_possible(const SurfaceDelta& delta) {
    return delta.hits > 0 && delta.hits <= limits::hits_per_map_max && delta.side_batch < 2 * limits::batches &&
           radiant_possible(delta.radiant, delta.hits) && xyz_possible(delta.y, delta.radiant, delta.hits);
}

bool ascends(const TexelDelta& a, const TexelDelta& b) { return a.texel < b.texel; }
bool ascends(const SurfaceDelta& a, const SurfaceDelta& b) {
    return std::tie(a.surface, a.side_batch) < std::tie(b.surface, b.side_batch);
}

/// Strictly ascending, so that the last index bounds all of them.
template <class T>
bool all_ascend(const std::vector<T>& deltas) {
    const auto not_before = [](const T& a, const T& b) { return !ascends(a, b); };
    return std::ranges::adjacent_find(deltas, not_before) == deltas.end();
}

}  // namespace

std::vector<ResultHits> pack_hits(const PartId& first, std::uint32_t light, std::span<const HitRecord> records,
                                  std::span<const std::uint32_t> energies, std::uint32_t hits_per_message) {
    ensure(hits_per_message >= 1 && hits_per_message <= limits::hits_per_message_max, "hits_per_message is in bounds");
    ensure(energies.empty() || energies.size() == records.size(), "energies are none or one a record");
    std::vector<ResultHits> parts;
    for (std::size_t begin = 0; begin < records.size(); begin += hits_per_message) {
        auto part_energies = energies.empty() ? std::vector<std::uint32_t>() : piece(energies, begin, hits_per_message);
        parts.emplace_back(nth_part(first, parts.size()), light, piece(records, begin, hits_per_message),
                           std::move(part_energies));
    }
    return parts;
}

std::vector<ResultMap> pack_map(const PartId& first, std::span<const TexelSums> texels,
                                std::span<const SurfaceBatches> surfaces) {
    const auto all_texels = texel_deltas(texels);
    const auto all_surfaces = surface_deltas(surfaces);
    std::vector<ResultMap> parts;
    std::size_t texel = 0, surface = 0;
    while (texel < all_texels.size() || surface < all_surfaces.size()) {
        auto some_texels = piece(std::span(all_texels), texel, limits::texel_deltas_per_message_max);
        auto some_surfaces = piece(std::span(all_surfaces), surface, limits::surface_deltas_per_message_max);
        texel += some_texels.size();
        surface += some_surfaces.size();
        parts.emplace_back(nth_part(first, parts.size()), std::move(some_texels), std::move(some_surfaces));
    }
    return parts;
}

std::vector<ResultKept> pack_kept(const PartId& first, std::span<const KeptHit> hits) {
    std::vector<ResultKept> parts;
    for (std::size_t begin = 0; begin < hits.size(); begin += limits::hits_per_message_max)
        parts.emplace_back(nth_part(first, parts.size()), piece(hits, begin, limits::hits_per_message_max));
    return parts;
}

bool valid_hits(const ResultHits& part, const Scene& scene, Absorption absorption) {
    if (part.light >= scene.lights.size() || part.energies.empty() != (absorption == Absorption::analog)) return false;
    return part.valid() &&
           std::ranges::all_of(part.records, [&](const HitRecord& record) { return valid_record(record, scene); });
}

bool valid_map(const ResultMap& part, std::uint64_t texels, std::size_t surfaces) {
    if (!part.valid() || !all_ascend(part.texels) || !all_ascend(part.surfaces)) return false;
    if (!part.texels.empty() && part.texels.back().texel >= texels) return false;
    if (!part.surfaces.empty() && part.surfaces.back().surface >= surfaces) return false;
    const auto possible = [](const auto& delta) { return delta_possible(delta); };
    return std::ranges::all_of(part.texels, possible) && std::ranges::all_of(part.surfaces, possible);
}

bool valid_kept(const ResultKept& part, const Scene& scene) {
    const auto possible = [&](const KeptHit& hit) {
        return hit.light < scene.lights.size() && valid_record(hit.record, scene);
    };
    return part.valid() && std::ranges::all_of(part.hits, possible);
}

void add_map(const ResultMap& part, std::span<TexelSums> texels, std::span<SurfaceBatches> surfaces) {
    for (const auto& delta : part.texels)
        texels[delta.texel] += TexelSums{delta.radiant, delta.x, delta.y, delta.z, delta.y_squared, delta.hits};
    for (const auto& delta : part.surfaces)
        surfaces[delta.surface][delta.side()][delta.batch()] += BatchSums{delta.radiant, delta.y, delta.hits};
}

HitCounts& HitCounts::operator+=(const HitCounts& other) {
    by_texel += other.by_texel;
    by_surface += other.by_surface;
    return *this;
}

HitCounts hits_of(const ResultHits& part) { return {part.records.size(), part.records.size()}; }

HitCounts hits_of(const ResultMap& part) {
    HitCounts counts;
    for (const auto& delta : part.texels) counts.by_texel += delta.hits;
    for (const auto& delta : part.surfaces) counts.by_surface += delta.hits;
    return counts;
}

}  // namespace lumenfarm::wire
