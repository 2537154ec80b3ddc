#pragma once

#include "common/solution/solution.h"
#include "common/support/limits.h"

#include <cstdint>
#include <type_traits>

/// Elements of bulk arrays that are not hit records: fixed little-endian layouts without padding, copied as they lie.
namespace lumenfarm::wire {

/// What one texel gained. 48 bytes. Fields as in TexelSums.
struct TexelDelta {
    std::uint32_t texel = 0;
    std::uint32_t hits = 0;  ///< at least 1
    std::int64_t radiant = 0, x = 0, y = 0, z = 0;
    std::uint64_t y_squared = 0;
    bool operator==(const TexelDelta&) const = default;
};
static_assert(sizeof(TexelDelta) == limits::texel_delta_bytes);
static_assert(limits::texels_max <= 0xffffffffu);

/// What one side of a surface gained in one batch of particles. 32 bytes. Fields as in BatchSums.
struct SurfaceDelta {
    std::uint32_t surface = 0;
    std::uint32_t side_batch = 0;  ///< side * 32 + batch, under 64
    std::int64_t radiant = 0, y = 0;
    std::uint64_t hits = 0;  ///< at least 1
    std::uint32_t side() const { return side_batch / limits::batches; }
    std::uint32_t batch() const { return side_batch % limits::batches; }
    bool operator==(const SurfaceDelta&) const = default;
};
static_assert(sizeof(SurfaceDelta) == limits::surface_delta_bytes);

static_assert(sizeof(KeptHit) == limits::kept_hit_bytes);

/// True for elements that may travel as a block: every bit pattern is a value and there is no padding.
template <class T>
inline constexpr bool travels_as_block = std::is_trivially_copyable_v<T>&& std::has_unique_object_representations_v<T>;
static_assert(travels_as_block<HitRecord> && travels_as_block<KeptHit> && travels_as_block<TexelDelta> &&
              travels_as_block<SurfaceDelta> && travels_as_block<Digest> && travels_as_block<std::byte>);

}  // namespace lumenfarm::wire
