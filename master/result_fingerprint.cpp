#include "master/result_fingerprint.h"

#include <xxhash.h>

#include <array>
#include <span>

namespace lumenfarm {

namespace {

/// What kind of sum a weight is for.
enum class Place : std::uint64_t { hit, kept_hit, texel, surface, balance, emitted_by_batch, flight };

class Fingerprint {
public:
    Fingerprint(std::uint64_t keep_threshold, std::uint64_t key) : keep_threshold_(keep_threshold), key_(key) {}

    void add(const wire::ResultHits& part) {
        for (std::size_t i = 0; i < part.records.size(); ++i) {
            const std::uint64_t energy = part.energies.empty() ? 0 : part.energies[i];
            sum_ += hash(Place::hit, std::as_bytes(std::span(&part.records[i], 1)),
                         std::uint64_t{part.light} << 32 | energy);
        }
    }
    void add(const wire::ResultMap& part) {
        for (const wire::TexelDelta& delta : part.texels)
            add(Place::texel, delta.texel,
                std::array<std::uint64_t, 6>{delta.hits, unsigned_of(delta.radiant), unsigned_of(delta.x),
                                             unsigned_of(delta.y), unsigned_of(delta.z), delta.y_squared});
        for (const wire::SurfaceDelta& delta : part.surfaces)
            add(Place::surface, std::uint64_t{delta.surface} << 32 | delta.side_batch,
                std::array<std::uint64_t, 3>{delta.hits, unsigned_of(delta.radiant), unsigned_of(delta.y)});
    }
    void add(const wire::ResultKept& part) {
        for (const KeptHit& hit : part.hits)
            if (keep_priority(hit) <= keep_threshold_)
                sum_ += hash(Place::kept_hit, std::as_bytes(std::span(&hit, 1)), 0);
    }
    void add(const wire::ResultFlights& part) {
        for (const wire::FlightRecord& flight : part.flights)
            sum_ += hash(Place::flight, std::as_bytes(std::span(&flight, 1)), part.subspace);
    }
    void add(const wire::ResultDone& done) {
        const EnergyBalance& balance = done.balance;
        add(Place::balance, 0,
            std::array<std::uint64_t, 7>{unsigned_of(balance.emitted), unsigned_of(balance.absorbed),
                                         unsigned_of(balance.escaped), unsigned_of(balance.cut_off), balance.particles,
                                         balance.hits, balance.bounce_limited});
        for (std::uint64_t batch = 0; batch < limits::batches; ++batch)
            add(Place::emitted_by_batch, batch,
                std::array<std::uint64_t, 1>{unsigned_of(balance.emitted_by_batch[batch])});
    }
    std::uint64_t sum() const { return sum_; }

private:
    static std::uint64_t unsigned_of(std::int64_t ticks) { return static_cast<std::uint64_t>(ticks); }

    std::uint64_t hash(Place place, std::span<const std::byte> bytes, std::uint64_t beside) const {
        return XXH3_64bits_withSeed(bytes.data(), bytes.size(), key_ + 0x9e37'79b9'7f4a'7c15u * (beside + 1)) +
               static_cast<std::uint64_t>(place);
    }
    template <std::size_t n>
    void add(Place place, std::uint64_t index, const std::array<std::uint64_t, n>& sums) {
        for (std::uint64_t i = 0; i < n; ++i) {
            const std::array<std::uint64_t, 3> where{static_cast<std::uint64_t>(place), index, i};
            // odd: no sum is multiplied by 0
            sum_ += sums[i] * (XXH3_64bits_withSeed(where.data(), sizeof where, key_) | 1);
        }
    }

    std::uint64_t keep_threshold_, key_;
    std::uint64_t sum_ = 0;
};

}  // namespace

std::uint64_t result_fingerprint(const StagedResult& result, std::uint64_t keep_threshold, std::uint64_t key) {
    Fingerprint fingerprint(keep_threshold, key);
    for (const wire::Message& message : result.messages())
        std::visit(
            [&]<class M>(const M& part) {
                if constexpr (requires { fingerprint.add(part); }) fingerprint.add(part);
            },
            message);
    return fingerprint.sum();
}

}  // namespace lumenfarm
