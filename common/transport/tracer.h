#pragma once

#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/support/result.h"
#include "common/transport/emission.h"
#include "common/transport/flight.h"
#include "common/transport/hit.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// The tracer: (scene, range of particles) -> hits. No socket, clock or thread; any number may run side by side over
/// one TracerScene.
namespace lumenfarm {

/// Consecutive particles of one source: [first, first + count). Sources are the lights; in the object-space strategy
/// also, behind them, the subspaces, whose particles in flight are numbered as they were filed (docs/subspaces.md).
struct ParticleRange {
    std::uint32_t source = 0;
    std::uint64_t first = 0;
    std::uint64_t count = 0;
    bool operator==(const ParticleRange&) const = default;
};

/// Energies in radiant ticks. emitted == absorbed + escaped + cut_off (law 5); cut_off may be negative under roulette.
struct EnergyBalance {
    std::int64_t emitted = 0;
    std::int64_t absorbed = 0;
    std::int64_t escaped = 0;
    std::int64_t cut_off = 0;
    std::uint64_t particles = 0;
    std::uint64_t hits = 0;
    std::uint64_t bounce_limited = 0;  ///< paths that reached limits::bounces_max
    std::array<std::int64_t, limits::batches> emitted_by_batch{};

    EnergyBalance& operator+=(const EnergyBalance& other) { return add(other, 1); }
    EnergyBalance& add(const EnergyBalance& other, std::int64_t times);
    bool closed() const { return emitted == absorbed + escaped + cut_off; }
    bool operator==(const EnergyBalance&) const = default;
};

inline void book_emission(EnergyBalance& balance, std::uint32_t particle, std::uint32_t energy) {
    ++balance.particles;
    balance.emitted += energy;
    balance.emitted_by_batch[batch_of(particle)] += energy;
}

/// The hits of a range. Their order carries no meaning (but is the same on every machine).
struct TracedHits {
    std::vector<HitRecord> records;
    /// Absorption::attenuate: incident energy of each record in ticks. Analog: empty, the energy is the light's for the
    /// record's wavelength.
    std::vector<std::uint32_t> energies;
    EnergyBalance balance;
    void clear();
};

struct LoggedRay;
class RayQuery;
/// The rays of a trace (ray_log.h), for those who look on. Of one particle they stand in the order of its path.
using RayLog = std::vector<LoggedRay>;

/// The scene made ready for tracing (Embree hierarchy, tables). Read-only and shared by threads.
class TracerScene {
public:
    /// `isa`: an Embree ISA name ("sse4.2", "avx2", "avx512") or empty for the best of this machine; the bits of a
    /// result do not depend on it. REQUIRES: validate(scene) succeeds; `scene` outlives this. Errors: bad_input (no
    /// light), failed (Embree out of memory).
    static Result<std::unique_ptr<TracerScene>> make(const Scene& scene, const std::string& isa = {});
    virtual ~TracerScene() = default;

    virtual const Scene& scene() const = 0;
    virtual const Emission& emission() const = 0;
    /// Traces the particles and appends to `hits`. REQUIRES: validate(spec); the range is within a
    /// light's particles.
    /// `log`, where given, receives every ray that was traced.
    virtual void trace(const JobSpec& spec, const ParticleRange& range, TracedHits& hits,
                       RayLog* log = nullptr) const = 0;
    /// Follows particles that have left their light to their end, and appends to `hits`. What they carry in is
    /// absorbed, escapes or is cut off, to the tick; the balance leaves out particles and what they emitted. REQUIRES:
    /// validate(spec); flights of this light.
    virtual void follow(const JobSpec& spec, std::uint32_t light, std::span<const Flight> flights,
                        TracedHits& hits) const = 0;
    virtual const RayQuery& query() const = 0;

    /// The first surface that a ray meets, for cameras and probes. Double precision, the same bits everywhere.
    struct Meeting {
        std::uint32_t triangle = none;  ///< none: nothing is met
        double distance = 0;            ///< in units of |direction|
        double b1 = 0, b2 = 0;
        bool back = false;
    };
    /// `from_triangle`: the triangle that the ray starts on, or none.
    virtual Meeting meet(Vec3d origin, Vec3d direction, std::uint32_t from_triangle = none) const = 0;

    virtual std::string isa() const = 0;  ///< the one in use
};

/// What makes a scene ready for tracing, as TracerScene::make does.
using TracerMaker = std::function<Result<std::unique_ptr<TracerScene>>(const Scene& scene, const std::string& isa)>;

}  // namespace lumenfarm
