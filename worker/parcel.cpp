#include "worker/parcel.h"

#include <algorithm>
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

/// Hits a part as the job asks, or more where a result would have too many parts.
ParcelReader::ParcelReader(const Parcel& parcel, std::uint64_t number) : parcel_(&parcel), number_(number) {
    const std::size_t fewest = parcel.records.size() / (limits::parts_per_result_max / 2) + 1;
    hits_in_a_part_ =
        std::min<std::size_t>(std::max<std::size_t>(parcel.hits_per_message, fewest), limits::hits_per_message_max);
}

void ParcelReader::rewind() {
    records_ = texels_ = surfaces_ = kept_ = 0;
    parts_ = 0;
    finished_ = false;
}

std::optional<wire::Message> ParcelReader::next() {
    if (finished_) return std::nullopt;
    const wire::PartId part(parcel_->job, number_, parts_);
    const bool maps_left = texels_ < parcel_->texels.size() || surfaces_ < parcel_->surfaces.size();
    ++parts_;
    if (records_ < parcel_->records.size()) return next_hits(part);
    if (maps_left) return next_map(part);
    if (kept_ < parcel_->kept.size()) return next_kept(part);
    finished_ = true;
    return wire::ResultDone(parcel_->job, number_, parcel_->claims, --parts_, parcel_->balance, parcel_->trace_s,
                            parcel_->cpu_s);
}

wire::Message ParcelReader::next_hits(const wire::PartId& part) {
    std::size_t energies_from = records_;
    std::vector<HitRecord> records = piece(parcel_->records, records_, hits_in_a_part_);
    std::vector<std::uint32_t> energies;
    if (!parcel_->energies.empty()) energies = piece(parcel_->energies, energies_from, hits_in_a_part_);
    return wire::ResultHits(part, parcel_->light, std::move(records), std::move(energies));
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
