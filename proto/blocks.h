#pragma once

#include "common/solution/solution.h"
#include "common/support/limits.h"
#include "common/transport/flight.h"
#include "common/transport/work_meter.h"

#include <array>
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

/// A particle in flight (transport/flight.h). 80 bytes; lengths and directions are the bits of doubles.
struct FlightRecord {
    std::array<std::uint64_t, 3> origin{}, direction{};
    std::uint64_t travelled = 0;
    std::uint32_t from_triangle = none;
    std::uint32_t light = 0;
    std::uint32_t particle = 0;
    std::uint32_t energy = 0, start_energy = 0;
    std::uint16_t bounce = 0, wavelength = 0;
    bool operator==(const FlightRecord&) const = default;
};
static_assert(sizeof(FlightRecord) == limits::flight_record_bytes);

FlightRecord pack_flight(const Flight& flight, std::uint32_t light);
Flight unpack_flight(const FlightRecord& record);
/// Whether the record is that of a particle that some scene may have.
bool possible_flight(const FlightRecord& record);

/// True for elements that may travel as a block: every bit pattern is a value and there is no padding.
template <class T>
inline constexpr bool travels_as_block = std::is_trivially_copyable_v<T>&& std::has_unique_object_representations_v<T>;
static_assert(travels_as_block<HitRecord> && travels_as_block<KeptHit> && travels_as_block<TexelDelta> &&
              travels_as_block<SurfaceDelta> && travels_as_block<FlightRecord> && travels_as_block<SubspaceWork> &&
              travels_as_block<Digest> && travels_as_block<std::byte>);

}  // namespace lumenfarm::wire
