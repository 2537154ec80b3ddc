#include "common/solution/solution.h"
#include "common/support/ensure.h"
#include "common/support/huge_pages.h"
#include "common/support/limits.h"

#include <algorithm>
#include <array>

namespace lumenfarm {
namespace {

struct Contribution {
    std::int64_t radiant, x, y, z;
};

std::int64_t weighted(std::uint32_t ticks, std::uint32_t ratio) {
    return static_cast<std::int64_t>((std::uint64_t{ticks} * ratio + (1u << 19)) >> 20);
}

Contribution contribution(std::uint32_t ticks, const XyzRatios& ratios) {
    return {ticks, weighted(ticks, ratios.xyz[0]), weighted(ticks, ratios.xyz[1]), weighted(ticks, ratios.xyz[2])};
}

void add_hit(TexelSums& sums, const Contribution& hit) {
    sums.radiant += hit.radiant;
    sums.x += hit.x;
    sums.y += hit.y;
    sums.z += hit.z;
    const auto y = static_cast<std::uint64_t>(hit.y >> y_squared_shift);
    sums.y_squared += y * y;
    ++sums.hits;
}

void add_hit(BatchSums& sums, const Contribution& hit) {
    sums.radiant += hit.radiant;
    sums.y += hit.y;
    ++sums.hits;
}

}  // namespace

TexelSums& TexelSums::add(const TexelSums& other, std::int64_t times) {
    radiant += times * other.radiant;
    x += times * other.x;
    y += times * other.y;
    z += times * other.z;
    y_squared += static_cast<std::uint64_t>(times) * other.y_squared;
    hits += static_cast<std::uint64_t>(times) * other.hits;
    return *this;
}

BatchSums& BatchSums::add(const BatchSums& other, std::int64_t times) {
    radiant += times * other.radiant;
    y += times * other.y;
    hits += static_cast<std::uint64_t>(times) * other.hits;
    return *this;
}

LightMap::LightMap(const TexelLayout& layout) : layout_(&layout), surfaces_(layout.surfaces()) {
    texels_.reserve(layout.texel_count());
    prefer_huge_pages(texels_.data(), layout.texel_count() * sizeof(TexelSums));
    texels_.resize(layout.texel_count());
}

void LightMap::add(const Emission& emission, std::uint32_t light, std::span<const HitRecord> records,
                   std::span<const std::uint32_t> energies) {
    ensure(energies.empty() || energies.size() == records.size(), "there is an energy for each record or none");
    const std::vector<std::uint32_t>& energy_by_bin = emission.lights[light].energy;
    const auto& ratios = xyz_ratios();
    // In blocks, since most adds wait for memory and for nothing else: where the sums of a block lie is asked for two
    // blocks before they are added to, and the sums themselves one block before.
    constexpr std::size_t block = 16;
    struct Places {
        std::array<TexelSums*, block> texels;
        std::array<BatchSums*, block> batches;
    };
    std::array<Places, 2> places;
    const std::size_t count = records.size();
    // always_inline: to the compiler a function that only asks does nothing, and it drops calls of it
    const auto ask_for_places = [&](std::size_t begin) __attribute__((always_inline)) {
        for (std::size_t i = begin; i < std::min(begin + block, count); ++i) layout_->prefetch(records[i].triangle);
    };
    const auto ask_for_sums = [&](std::size_t begin) __attribute__((always_inline)) {
        Places& of = places[begin / block % 2];
        for (std::size_t i = begin; i < std::min(begin + block, count); ++i) {
            const HitRecord& record = records[i];
            TexelSums* const texel = of.texels[i - begin] = texels_.data() + layout_->texel_of(record);
            BatchSums* const batch = of.batches[i - begin] =
                &surfaces_[layout_->surface_of(record.triangle)][record.side()][record.batch()];
            __builtin_prefetch(texel, 1);
            __builtin_prefetch(reinterpret_cast<const char*>(texel) + sizeof(TexelSums) - 1, 1);
            __builtin_prefetch(batch, 1);
        }
    };
    ask_for_places(0);
    ask_for_places(block);
    ask_for_sums(0);
    for (std::size_t begin = 0; begin < count; begin += block) {
        ask_for_places(begin + 2 * block);
        ask_for_sums(begin + block);
        const Places& of = places[begin / block % 2];
        for (std::size_t i = begin; i < std::min(begin + block, count); ++i) {
            const std::uint32_t bin = records[i].wavelength;
            const std::uint32_t ticks = energies.empty() ? energy_by_bin[bin] : energies[i];
            const Contribution hit = contribution(ticks, ratios[bin]);
            add_hit(*of.texels[i - begin], hit);
            add_hit(*of.batches[i - begin], hit);
        }
    }
}

/// Texel by texel, so that many maps cost little more than one.
void LightMap::add(std::span<const Term> terms) {
    for (const Term& term : terms)
        ensure(texels_.size() == term.map->texels_.size() && surfaces_.size() == term.map->surfaces_.size(),
               "maps of one scene and layout are added");
    for (std::size_t i = 0; i < texels_.size(); ++i)
        for (const Term& term : terms) texels_[i].add(term.map->texels_[i], term.times);
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
        for (std::size_t side = 0; side < 2; ++side)
            for (std::size_t batch = 0; batch < limits::batches; ++batch)
                for (const Term& term : terms)
                    surfaces_[i][side][batch].add(term.map->surfaces_[i][side][batch], term.times);
}

void LightMap::clear() {
    std::fill(texels_.begin(), texels_.end(), TexelSums{});
    std::fill(surfaces_.begin(), surfaces_.end(), SurfaceBatches{});
}

}  // namespace lumenfarm
