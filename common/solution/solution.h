#pragma once

#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/solution/interval_set.h"
#include "common/solution/texel_layout.h"
#include "common/spectrum/spectrum.h"
#include "common/support/digest.h"
#include "common/support/result.h"
#include "common/transport/emission.h"
#include "common/transport/tracer.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

/// The light solution: exact integer sums per texel and per surface, and the kept hits. Everything commutes.
namespace lumenfarm {

/// y is shifted before it is squared, so that the sum of the squares of a job fits.
inline constexpr int y_squared_shift = 4;

/// Sums of one texel. xyz: ticks weighted by xyz_ratios(). y_squared: sum of (y >> y_squared_shift)^2, for standard
/// errors.
struct TexelSums {
    std::int64_t radiant = 0, x = 0, y = 0, z = 0;
    std::uint64_t y_squared = 0;
    std::uint64_t hits = 0;
    TexelSums& operator+=(const TexelSums& other) { return add(other, 1); }
    TexelSums& add(const TexelSums& other, std::int64_t times);
    bool operator==(const TexelSums&) const = default;
};

/// Sums of one side of a surface in one batch of particles.
struct BatchSums {
    std::int64_t radiant = 0, y = 0;
    std::uint64_t hits = 0;
    BatchSums& operator+=(const BatchSums& other) { return add(other, 1); }
    BatchSums& add(const BatchSums& other, std::int64_t times);
    bool operator==(const BatchSums&) const = default;
};
using SurfaceBatches = std::array<std::array<BatchSums, limits::batches>, 2>;  ///< by side

/// A kept hit: the record, its light and incident energy [ticks]. `priority` is a hash of them; a solution keeps the
/// job's keep_hits hits of lowest (priority, content), which is a random sample that no order of arrival changes.
struct KeptHit {
    HitRecord record;
    std::uint32_t light = 0;
    std::uint32_t energy = 0;
    bool operator==(const KeptHit&) const = default;
};
std::uint64_t keep_priority(const KeptHit& hit);

/// Adds hits into dense sums. One of these is a worker's map as well as the master's solution.
class LightMap {
public:
    /// REQUIRES: `layout` outlives this.
    explicit LightMap(const TexelLayout& layout);

    /// `energies` empty: analog, energies from `emission`. REQUIRES: records valid for the scene (valid_record).
    void add(const Emission& emission, std::uint32_t light, std::span<const HitRecord> records,
             std::span<const std::uint32_t> energies);
    /// So many times what another one holds; -1 takes it away.
    struct Term {
        const LightMap* map = nullptr;
        std::int64_t times = 1;
    };
    /// REQUIRES: maps of one scene and layout.
    void add(std::span<const Term> terms);
    void clear();

    std::vector<TexelSums>& texels() { return texels_; }
    const std::vector<TexelSums>& texels() const { return texels_; }
    std::vector<SurfaceBatches>& surfaces() { return surfaces_; }
    const std::vector<SurfaceBatches>& surfaces() const { return surfaces_; }

private:
    const TexelLayout* layout_;
    std::vector<TexelSums> texels_;
    std::vector<SurfaceBatches> surfaces_;
};

/// True when every index of the record lies within the scene, so that adding it is safe.
inline bool valid_record(const HitRecord& record, const Scene& scene) {
    return record.triangle < scene.triangles.size() && record.b1 + record.b2 <= 65'536 &&
           record.wavelength < wavelength_bins;
}

/// The k hits of lowest priority seen so far.
class KeptHits {
public:
    explicit KeptHits(std::uint64_t capacity) : capacity_(capacity) {}
    void offer(const KeptHit& hit);
    /// A hit with a priority above this is not kept; falls as hits arrive. Workers need not send such hits.
    std::uint64_t threshold() const;
    /// Sorted by (priority, content): canonical.
    std::vector<KeptHit> sorted() const;
    std::uint64_t capacity() const { return capacity_; }

private:
    std::uint64_t capacity_;
    struct Entry {
        std::uint64_t priority;
        KeptHit hit;
    };
    static bool before(const Entry& a, const Entry& b);
    std::vector<Entry> heap_;  ///< max-heap by `before`, at most capacity_
};

struct SolutionTime {
    double total_s = 0;
    double trace_s = 0;  ///< processor time in the tracer, summed over threads
    std::uint32_t workers = 0;
};

/// A result: whole, or of an interrupted job. What is derived from the scene (layout, emission) is not stored.
struct Solution {
    Digest scene;
    JobSpec spec;
    std::vector<IntervalSet> committed;  ///< by light
    EnergyBalance balance;
    std::vector<TexelSums> texels;
    std::vector<SurfaceBatches> surfaces;
    std::vector<KeptHit> kept;  ///< canonical order
    SolutionTime time;          ///< not part of the digest

    bool complete() const { return balance.particles == spec.particles; }
};

/// SHA-256 over the canonical bytes of everything that law 1 fixes: scene, the deciding fields of the spec, intervals,
/// sums and kept hits; not names, times, packing or strategy.
Digest solution_digest(const Solution& solution);

}  // namespace lumenfarm
