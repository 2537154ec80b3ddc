#pragma once

#include "common/solution/solution.h"
#include "proto/messages.h"
#include "worker/job_context.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

/// A closed result on its way to the master.
namespace lumenfarm {

/// Hits of one light.
struct LightHits {
    std::uint32_t light = 0;
    std::vector<HitRecord> records;
    std::vector<std::uint32_t> energies;
};

struct Parcel {
    JobId job = 0;
    std::uint32_t hits_per_message = 0;  ///< and flights
    std::vector<wire::Claim> claims;
    EnergyBalance balance;
    double trace_s = 0;
    double cpu_s = 0;

    std::vector<LightHits> hits;                                       ///< packing records
    std::map<std::uint32_t, std::vector<wire::FlightRecord>> flights;  ///< by the subspace in which they go on
    std::map<std::uint32_t, SubspaceWork> work;                        ///< by subspace

    std::vector<wire::TexelDelta> texels;  ///< packing maps
    std::vector<wire::SurfaceDelta> surfaces;
    std::vector<KeptHit> kept;

    std::size_t bytes() const;
    /// Hits of one light go together. `energies`: empty, or one a record.
    void add_hits(std::uint32_t light, std::span<const HitRecord> records, std::span<const std::uint32_t> energies);
    void add_work(const SubspaceWork& more);
    /// What goes on where the claim before ended is one with it.
    void add_claim(const wire::Claim& claim);
};

/// Packing maps: puts the sums that are not zero into a parcel that has none. They are zero then.
void move_sums(LightMap& sums, Parcel& parcel);

/// The messages of a parcel, one at a time, so that no more of them are in memory than the connection takes.
class ParcelReader {
public:
    /// `number`: the result's number on the wire.
    ParcelReader(const Parcel& parcel, std::uint64_t number);

    /// The next part, or the ResultDone as the last; nothing after it.
    std::optional<wire::Message> next();
    bool begun() const { return parts_ > 0 && !finished_; }
    bool finished() const { return finished_; }
    void rewind();

private:
    wire::Message next_hits(const wire::PartId& part);
    wire::Message next_map(const wire::PartId& part);
    wire::Message next_kept(const wire::PartId& part);
    wire::Message next_flights(const wire::PartId& part);
    wire::Message next_work(const wire::PartId& part);

    const Parcel* parcel_;
    std::uint64_t number_;
    std::size_t hits_in_a_part_, flights_in_a_part_;
    std::size_t lights_ = 0;                            ///< whose hits are all sent
    std::size_t records_ = 0;                           ///< of the next light that are sent
    std::size_t texels_ = 0, surfaces_ = 0, kept_ = 0;  ///< sent so far
    std::optional<std::uint32_t> subspace_;             ///< whose flights are being sent; none: all are
    std::size_t flights_ = 0;                           ///< of them that are sent
    bool work_sent_ = false;
    std::uint32_t parts_ = 0;
    bool finished_ = false;
};

}  // namespace lumenfarm
