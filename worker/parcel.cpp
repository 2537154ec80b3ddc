#include "worker/parcel.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace lumenfarm {

namespace {

template <class T>
std::vector<T> piece(const std::vector<T>& all, std::size_t& from, std::size_t count_max) {
    const std::size_t count = std::min(count_max, all.size() - from);
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(from);
    from += count;
    return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

}  // namespace

std::size_t Parcel::bytes() const {
    std::size_t bytes = texels.size() * sizeof(wire::TexelDelta) + surfaces.size() * sizeof(wire::SurfaceDelta) +
                        kept.size() * sizeof(KeptHit);
    for (const LightHits& of : hits)
        bytes += of.records.size() * sizeof(HitRecord) + of.energies.size() * sizeof(std::uint32_t);
    for (const auto& [subspace, those] : flights) bytes += those.size() * sizeof(wire::FlightRecord);
    return bytes;
}

void Parcel::add_hits(std::uint32_t light, std::span<const HitRecord> records,
                      std::span<const std::uint32_t> energies) {
    if (records.empty()) return;
    const auto same = [&](const LightHits& of) { return of.light == light; };
    const auto into = std::find_if(hits.rbegin(), hits.rend(), same);
    LightHits& of_light = into == hits.rend() ? hits.emplace_back(LightHits{light, {}, {}}) : *into;
    of_light.records.insert(of_light.records.end(), records.begin(), records.end());
    of_light.energies.insert(of_light.energies.end(), energies.begin(), energies.end());
}

void Parcel::add_work(const SubspaceWork& more) {
    SubspaceWork& all = work[more.subspace];
    all.subspace = more.subspace;
    all.hits = static_cast<std::uint32_t>(std::min(std::uint64_t{all.hits} + more.hits, limits::hits_per_map_max));
    all.nanoseconds = std::min(all.nanoseconds + more.nanoseconds, wire::work_nanoseconds_max);
}

void Parcel::add_claim(const wire::Claim& claim) {
    wire::Claim* last = claims.empty() ? nullptr : &claims.back();
    const bool goes_on = last && last->lease == claim.lease && last->range.source == claim.range.source &&
                         last->range.first + last->range.count == claim.range.first;
    if (goes_on)
        last->range.count += claim.range.count;
    else
        claims.push_back(claim);
}

void move_sums(LightMap& sums, Parcel& parcel) {
    const auto& texels = sums.texels();
    parcel.texels.reserve(
        std::count_if(texels.begin(), texels.end(), [](const auto& texel) { return texel.hits > 0; }));
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const TexelSums& texel = texels[i];
        if (texel.hits == 0) continue;
        parcel.texels.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(texel.hits), texel.radiant,
                                 texel.x, texel.y, texel.z, texel.y_squared});
    }
    const auto& surfaces = sums.surfaces();
    for (std::size_t i = 0; i < surfaces.size(); ++i)
        for (std::uint32_t side_batch = 0; side_batch < 2 * limits::batches; ++side_batch) {
            const BatchSums& batch = surfaces[i][side_batch / limits::batches][side_batch % limits::batches];
            if (batch.hits > 0)
                parcel.surfaces.push_back(
                    {static_cast<std::uint32_t>(i), side_batch, batch.radiant, batch.y, batch.hits});
        }
    sums.clear();
}

/// Hits and flights a part as the job asks, or more where a result would have too many parts.
ParcelReader::ParcelReader(const Parcel& parcel, std::uint64_t number) : parcel_(&parcel), number_(number) {
    const auto in_a_part = [&](std::size_t in_all, std::size_t most) {
        const std::size_t fewest = in_all / (limits::parts_per_result_max / 4) + 1;
        return std::min(std::max<std::size_t>(parcel.hits_per_message, fewest), most);
    };
    std::size_t records = 0, flights = 0;
    for (const LightHits& of : parcel.hits) records += of.records.size();
    for (const auto& [subspace, those] : parcel.flights) flights += those.size();
    hits_in_a_part_ = in_a_part(records, limits::hits_per_message_max);
    flights_in_a_part_ = in_a_part(flights, limits::flights_per_message_max);
    rewind();
}

void ParcelReader::rewind() {
    lights_ = records_ = texels_ = surfaces_ = kept_ = flights_ = 0;
    subspace_.reset();
    if (!parcel_->flights.empty()) subspace_ = parcel_->flights.begin()->first;
    work_sent_ = parcel_->work.empty();
    parts_ = 0;
    finished_ = false;
}

std::optional<wire::Message> ParcelReader::next() {
    if (finished_) return std::nullopt;
    const wire::PartId part(parcel_->job, number_, parts_);
    const bool maps_left = texels_ < parcel_->texels.size() || surfaces_ < parcel_->surfaces.size();
    ++parts_;
    if (lights_ < parcel_->hits.size()) return next_hits(part);
    if (maps_left) return next_map(part);
    if (kept_ < parcel_->kept.size()) return next_kept(part);
    if (subspace_) return next_flights(part);
    if (!work_sent_) return next_work(part);
    finished_ = true;
    return wire::ResultDone(parcel_->job, number_, parcel_->claims, --parts_, parcel_->balance, parcel_->trace_s,
                            parcel_->cpu_s);
}

wire::Message ParcelReader::next_hits(const wire::PartId& part) {
    const LightHits& hits = parcel_->hits[lights_];
    std::size_t energies_from = records_;
    std::vector<HitRecord> records = piece(hits.records, records_, hits_in_a_part_);
    std::vector<std::uint32_t> energies;
    if (!hits.energies.empty()) energies = piece(hits.energies, energies_from, hits_in_a_part_);
    if (records_ == hits.records.size()) {
        ++lights_;
        records_ = 0;
    }
    return wire::ResultHits(part, hits.light, std::move(records), std::move(energies));
}

wire::Message ParcelReader::next_flights(const wire::PartId& part) {
    const auto at = parcel_->flights.find(*subspace_);
    wire::ResultFlights message(part, at->first, piece(at->second, flights_, flights_in_a_part_));
    if (flights_ < at->second.size()) return message;
    flights_ = 0;
    const auto after = std::next(at);
    subspace_ = after == parcel_->flights.end() ? std::nullopt : std::optional(after->first);
    return message;
}

wire::Message ParcelReader::next_work(const wire::PartId& part) {
    std::vector<SubspaceWork> work;
    for (const auto& [subspace, each] : parcel_->work) work.push_back(each);
    work_sent_ = true;
    return wire::ResultWork(part, std::move(work));
}

wire::Message ParcelReader::next_map(const wire::PartId& part) {
    auto texels = piece(parcel_->texels, texels_, limits::texel_deltas_per_message_max);
    auto surfaces = piece(parcel_->surfaces, surfaces_, limits::surface_deltas_per_message_max);
    return wire::ResultMap(part, std::move(texels), std::move(surfaces));
}

wire::Message ParcelReader::next_kept(const wire::PartId& part) {
    return wire::ResultKept(part, piece(parcel_->kept, kept_, limits::hits_per_message_max));
}

}  // namespace lumenfarm
