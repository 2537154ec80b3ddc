#include "tests/simulation/simulated_bytes.h"

#include <algorithm>
#include <utility>

namespace lumenfarm::testing {

using Fate = SimulatedBytes::Fate;

namespace {

std::uint64_t below(std::uint64_t bound, std::mt19937_64& random) {
    return std::uniform_int_distribution<std::uint64_t>(0, bound - 1)(random);
}

/// In which order the system was writing when the power failed.
enum class Order { all_written, none_written, as_given, any };

Fate fate_of(Order order, std::size_t change, std::size_t reached, std::mt19937_64& random) {
    if (order == Order::all_written || (order == Order::as_given && change < reached)) return Fate::lasts;
    if (order == Order::as_given && change == reached) return Fate::torn;
    return order == Order::any ? static_cast<Fate>(below(3, random)) : Fate::lost;
}

/// Bytes of a torn write that are on the disk: up to one of the borders of sectors inside it.
std::uint64_t torn_bytes(std::uint64_t offset, std::uint64_t bytes, std::mt19937_64& random) {
    const std::uint64_t first_border = offset / sector_bytes + 1;
    const std::uint64_t last_border = (offset + bytes - 1) / sector_bytes;
    if (bytes == 0 || last_border < first_border) return 0;
    return (first_border + below(last_border - first_border + 1, random)) * sector_bytes - offset;
}

}  // namespace

void SimulatedBytes::apply(const Change& change, std::vector<std::byte>& to) {
    if (const auto* truncate = std::get_if<Truncate>(&change)) return to.resize(truncate->bytes);
    const Write& write = std::get<Write>(change);
    if (write.bytes.empty()) return;
    to.resize(std::max<std::size_t>(to.size(), write.offset + write.bytes.size()));
    std::ranges::copy(write.bytes, to.begin() + static_cast<std::ptrdiff_t>(write.offset));
}

bool SimulatedBytes::keep_some(Change& change, Fate fate, std::mt19937_64& random) {
    if (fate != Fate::torn) return fate == Fate::lasts;
    auto* write = std::get_if<Write>(&change);
    if (!write) return false;
    write->bytes.resize(torn_bytes(write->offset, write->bytes.size(), random));
    return true;
}

void SimulatedBytes::change(Change change) {
    apply(change, seen_);
    changes_.push_back(std::move(change));
}

void SimulatedBytes::write(std::uint64_t offset, std::span<const std::byte> bytes) {
    change(Write{offset, {bytes.begin(), bytes.end()}});
}

void SimulatedBytes::truncate(std::uint64_t bytes) { change(Truncate{bytes}); }

void SimulatedBytes::keep_all() {
    for (const Change& change : changes_) apply(change, lasting_);
    changes_.clear();
}

void SimulatedBytes::sync_badly(std::mt19937_64& random) {
    std::erase_if(changes_, [&](const Change&) { return below(2, random) == 0; });
}

void SimulatedBytes::cut_power(std::mt19937_64& random) {
    if (!changes_.empty()) {
        const auto order = static_cast<Order>(below(4, random));
        const std::uint64_t reached = below(changes_.size(), random);
        std::vector<Change> kept;
        for (std::size_t i = 0; i < changes_.size(); ++i)
            if (keep_some(changes_[i], fate_of(order, i, reached, random), random))
                kept.push_back(std::move(changes_[i]));
        changes_ = std::move(kept);
    }
    keep_all();
    seen_ = lasting_;
}

}  // namespace lumenfarm::testing
