#include "worker/paced/stored_hits.h"

#include "common/solution/solution.h"
#include "common/support/file.h"
#include "proto/messages.h"
#include "worker/parcel.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <utility>
#include <variant>

/// The file: frames as they go over the wire, a JobInfo that says what follows, then a result for each block of each
/// light in turn, packing records.
namespace lumenfarm::worker {

namespace {

constexpr std::uint64_t particles_wanted = std::uint64_t{1} << 18;  ///< of each light, or
constexpr std::uint64_t particles_max = std::uint64_t{1} << 20;     ///< of all together
constexpr std::uint64_t batches_repeat = std::uint64_t{64} * limits::batches;
static_assert(batches_repeat % StoredHits::block_particles == 0 && std::has_single_bit(batches_repeat));
static_assert(particles_max / StoredHits::lights_max >= batches_repeat);
constexpr std::uint64_t file_bytes_max = std::uint64_t{8} << 30;

std::uint64_t blocks_of_each(std::size_t lights) {
    const std::uint64_t particles = std::bit_floor(std::min(particles_wanted, particles_max / lights));
    return std::max(particles, batches_repeat) / StoredHits::block_particles;
}

ParticleRange range_of(std::uint32_t light, std::uint64_t block) {
    return {light, block * StoredHits::block_particles, StoredHits::block_particles};
}

wire::JobInfo title_of(const StoredJob& job) {
    JobSpec spec = job.spec;
    spec.packing = Packing::records;
    return {0, job.scene, 0, spec, 1, 1};
}

void append(std::vector<std::byte>& bytes, const wire::Message& message) {
    const auto frame = wire::encode(message);
    bytes.insert(bytes.end(), frame.begin(), frame.end());
}

void append(std::vector<std::byte>& bytes, const ParticleRange& range, std::uint64_t number, const TracedHits& hits) {
    Parcel parcel;
    parcel.hits_per_message = limits::hits_per_message_max;
    parcel.claims.emplace_back(number, 0, range);
    parcel.balance = hits.balance;
    parcel.add_hits(range.source, hits.records, hits.energies);
    ParcelReader reader(parcel, number);
    while (const auto message = reader.next()) append(bytes, *message);
}

/// Messages out of a file. None: it ends, or what follows is none.
class MessageReader {
public:
    explicit MessageReader(std::span<const std::byte> bytes) : left_(bytes) {}
    std::optional<wire::Message> next() {
        const auto frame = parser_.consume(left_);
        if (!frame || !*frame) return std::nullopt;
        auto message = wire::decode((*frame)->header.type, (*frame)->payload);
        return message ? std::optional(std::move(*message)) : std::nullopt;
    }

private:
    std::span<const std::byte> left_;
    wire::FrameParser parser_{wire::TypeGate{}};
};

bool is_possible(const wire::ResultHits& part, const ParticleRange& range, const TracerScene& tracer) {
    return part.light == range.source &&
           std::all_of(part.records.begin(), part.records.end(),
                       [&](const HitRecord& record) { return valid_record(record, tracer.scene()); });
}

/// A block as append() wrote it: messages of hits, where there are any, and the end.
std::optional<TracedHits> next_block(MessageReader& reader, const ParticleRange& range, const TracerScene& tracer) {
    TracedHits hits;
    while (auto message = reader.next()) {
        if (const auto* part = std::get_if<wire::ResultHits>(&*message); part && is_possible(*part, range, tracer)) {
            hits.records.insert(hits.records.end(), part->records.begin(), part->records.end());
            hits.energies.insert(hits.energies.end(), part->energies.begin(), part->energies.end());
            continue;
        }
        const auto* done = std::get_if<wire::ResultDone>(&*message);
        if (!done || done->claims.front().range != range || done->balance.hits != hits.records.size()) break;
        hits.balance = done->balance;
        return hits;
    }
    return std::nullopt;
}

}  // namespace

bool same_paths(const JobSpec& a, const JobSpec& b) {
    return a.seed == b.seed && a.absorption == b.absorption && a.cutoff_rule == b.cutoff_rule && a.cutoff == b.cutoff;
}

StoredHits StoredHits::trace(const TracerScene& tracer, const StoredJob& job) {
    StoredHits stored;
    stored.blocks_.resize(tracer.emission().lights.size());
    for (std::uint32_t light = 0; light < stored.blocks_.size(); ++light) {
        stored.blocks_[light].resize(blocks_of_each(stored.blocks_.size()));
        for (std::uint64_t block = 0; block < stored.blocks_[light].size(); ++block)
            tracer.trace(job.spec, range_of(light, block), stored.blocks_[light][block]);
    }
    return stored;
}

Result<void> StoredHits::write(const std::filesystem::path& file, const StoredJob& job) const {
    std::vector<std::byte> bytes;
    append(bytes, title_of(job));
    std::uint64_t number = 0;
    for (std::uint32_t light = 0; light < blocks_.size(); ++light)
        for (std::uint64_t block = 0; block < blocks_[light].size(); ++block)
            append(bytes, range_of(light, block), ++number, blocks_[light][block]);
    return write_file(file, bytes);
}

Result<StoredHits> StoredHits::read(const std::filesystem::path& file, const TracerScene& tracer,
                                    const StoredJob& job) {
    const auto bytes = read_file(file, file_bytes_max);
    if (!bytes) return bytes.error();
    MessageReader reader(*bytes);
    const auto first = reader.next();
    const auto* title = first ? std::get_if<wire::JobInfo>(&*first) : nullptr;
    if (!title) return bad_input("'" + file.string() + "' has no stored results");
    if (title->scene != job.scene || !same_paths(title->spec, job.spec))
        return bad_input("the results in '" + file.string() + "' are of another job");
    StoredHits stored;
    stored.blocks_.resize(tracer.emission().lights.size());
    for (std::uint32_t light = 0; light < stored.blocks_.size(); ++light)
        for (std::uint64_t block = 0; block < blocks_of_each(stored.blocks_.size()); ++block) {
            auto hits = next_block(reader, range_of(light, block), tracer);
            if (!hits) return bad_input("'" + file.string() + "' is damaged");
            stored.blocks_[light].push_back(std::move(*hits));
        }
    return stored;
}

bool StoredHits::operator==(const StoredHits& other) const {
    return std::equal(blocks_.begin(), blocks_.end(), other.blocks_.begin(), other.blocks_.end(),
                      [](const auto& a, const auto& b) {
                          return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
                              return x.records == y.records && x.energies == y.energies && x.balance == y.balance;
                          });
                      });
}

}  // namespace lumenfarm::worker
