#include "master/flight_queues.h"

#include "common/support/ensure.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace lumenfarm {

namespace {

std::int64_t energy_of(const FlightQueues::Flights& flights) {
    std::int64_t ticks = 0;
    for (const wire::FlightRecord& flight : flights) ticks += flight.energy;
    return ticks;
}

}  // namespace

FlightQueues::Filed FlightQueues::file(std::uint32_t subspace, Flights flights) {
    Filed filed{subspace, queues_[subspace].filed, std::make_shared<const Flights>(std::move(flights))};
    add(filed);
    return filed;
}

void FlightQueues::add(const Filed& filed) {
    Queue& queue = queues_[filed.subspace];
    ensure(filed.first >= queue.filed && !filed.flights->empty(), "flights are filed in order");
    queue.filed = filed.first + filed.flights->size();
    keep(filed);
}

void FlightQueues::lend(const Filed& filed) {
    ensure(may_lend(filed.subspace, filed.first, filed.flights->size()), "a flight is lent once");
    Queue& queue = queues_[filed.subspace];
    queue.filed = std::max(queue.filed, filed.first + filed.flights->size());
    keep(filed);
}

void FlightQueues::keep(const Filed& filed) {
    energy_ += energy_of(*filed.flights);
    count_ += filed.flights->size();
    queues_[filed.subspace].blocks.emplace(filed.first, Block{filed.flights, filed.flights->size()});
}

bool FlightQueues::may_lend(std::uint32_t subspace, std::uint64_t first, std::uint64_t count) const {
    const auto& blocks = queues_[subspace].blocks;
    const auto after = blocks.lower_bound(first + count);
    return after == blocks.begin() || std::prev(after)->first + std::prev(after)->second.flights->size() <= first;
}

template <class Visit>
void FlightQueues::each(std::uint32_t subspace, std::uint64_t first, std::uint64_t count, Visit visit) const {
    const auto& blocks = queues_[subspace].blocks;
    auto block = blocks.upper_bound(first);
    for (std::uint64_t number = first; number < first + count; ++block) {
        ensure(block != blocks.begin(), "flights that are asked for are here");
        const auto& [begin, here] = *std::prev(block);
        const std::uint64_t end = std::min(first + count, begin + here.flights->size());
        ensure(begin <= number && number < end, "flights that are asked for are here");
        for (; number < end; ++number) visit((*here.flights)[number - begin]);
        if (number < first + count) ensure(block != blocks.end(), "flights that are asked for are here");
    }
}

void FlightQueues::remove(std::uint32_t subspace, std::uint64_t first, std::uint64_t count) {
    energy_ -= energy(subspace, first, count);
    count_ -= count;
    auto& blocks = queues_[subspace].blocks;
    auto block = std::prev(blocks.upper_bound(first));
    for (std::uint64_t number = first; number < first + count;) {
        const std::uint64_t end = std::min(first + count, block->first + block->second.flights->size());
        const std::uint64_t removed = end - number;
        ensure(block->second.left >= removed, "a flight is removed once");
        block->second.left -= removed;
        number = end;
        block = block->second.left == 0 ? blocks.erase(block) : std::next(block);
    }
}

FlightQueues::Flights FlightQueues::at(std::uint32_t subspace, std::uint64_t first, std::uint64_t count) const {
    Flights flights;
    flights.reserve(count);
    each(subspace, first, count, [&](const wire::FlightRecord& flight) { flights.push_back(flight); });
    return flights;
}

std::int64_t FlightQueues::energy(std::uint32_t subspace, std::uint64_t first, std::uint64_t count) const {
    std::int64_t ticks = 0;
    each(subspace, first, count, [&](const wire::FlightRecord& flight) { ticks += flight.energy; });
    return ticks;
}

std::int64_t energy_of(const FlightQueues& flights, const PreparedJob& prepared, std::span<const wire::Claim> claims) {
    const auto lights = static_cast<std::uint32_t>(prepared.particles.size());
    std::int64_t ticks = 0;
    for (const wire::Claim& claim : claims)
        if (claim.range.source >= lights)
            ticks += flights.energy(claim.range.source - lights, claim.range.first, claim.range.count);
    return ticks;
}

}  // namespace lumenfarm
