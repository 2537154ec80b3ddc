#include "tests/simulation/farm.h"

#include <algorithm>
#include <cmath>
#include <utility>

/// What is against a simulated farm, and when.
namespace lumenfarm::testing {

void Farm::begin_storms() {
    repeat(options_.seconds_between_drops, [this] { drop_one(); });
    repeat(options_.seconds_between_crashes, [this] { crash_one(); });
    if (!relays_.empty()) repeat(options_.seconds_between_relay_crashes, [this] { crash_relay(); });
    repeat(options_.seconds_between_power_cuts, [this] { cut_power(); });
    repeat(options_.seconds_between_full_disks, [this] { fill_disk(); });
    repeat(options_.seconds_between_partitions, [this] { partition(); });
    if (std::isfinite(options_.storm_seconds))
        world_.clock.at(options_.storm_seconds, [this] {
            world_.note(Who::farm, 0, "the storms are over");
            master_->calm_disk();
        });
}

/// Again and again at random times, until the storms are over. Never when `mean_s` is 0.
void Farm::repeat(double mean_s, std::function<void()> event) {
    if (mean_s <= 0) return;
    const double next_s = now_s() + world_.chance.exponential(mean_s);
    if (next_s > options_.storm_seconds) return;
    world_.clock.at(next_s, [this, mean_s, event = std::move(event)] {
        event();
        repeat(mean_s, event);
    });
}

/// Somebody's connections: a worker's or, less often, a client's.
void Farm::drop_one() {
    const std::uint64_t one = world_.chance.number(0, 4 * workers_.size() + clients_.size() - 1);
    const HostId host = one < 4 * workers_.size() ? host_of_worker(one / 4) : host_of_client(one - 4 * workers_.size());
    trouble(host, now_s());
    world_.network.cut(host);
    for (SimulatedRelay& relay : relays_) relay.below().cut(host);
    if (relays_.empty() || !world_.chance.happens(0.3)) return;
    const std::size_t index = world_.chance.number(0, relays_.size() - 1);
    trouble(host_of_relay(index), now_s());
    world_.network.cut(host_of_relay(index));
    relays_.front().below().cut(host_of_relay(index));
}

void Farm::crash_relay() {
    const std::size_t index = world_.chance.number(0, relays_.size() - 1);
    if (!relays_[index].alive()) return;
    const bool machine_too = world_.chance.happens(options_.machine_crashes);
    relays_[index].end(machine_too);
    const double down_s = world_.chance.exponential(machine_too ? 10 : 1);
    trouble(host_of_relay(index), now_s() + down_s);
    world_.clock.after(down_s, [this, index] { start_relay(index); });
}

void Farm::crash_one() {
    const std::size_t index = world_.chance.number(0, workers_.size() - 1);
    if (!workers_[index].alive()) return;
    const bool machine_too = world_.chance.happens(options_.machine_crashes);
    workers_[index].end(machine_too);
    const double down_s = machine_too ? world_.chance.exponential(10) : 0;
    trouble(host_of_worker(index), now_s() + down_s);
    world_.clock.after(down_s, [this, index] { start_worker(index); });
}

/// Most often in the midst of something.
void Farm::cut_power() {
    if (!master_->core()) return;
    if (!world_.chance.happens(0.2)) return master_->cut_power_soon();
    master_->end(world_.chance.happens(0.5));
}

void Farm::fill_disk() { master_->fill_disk(world_.chance.uniform(0.5, 15)); }

/// Short ones are more frequent; one in six takes the master from everybody.
void Farm::partition() {
    Chance& chance = world_.chance;
    const double most_s = std::min(options_.partition_seconds_max, options_.storm_seconds - now_s());
    if (most_s <= 1) return;
    const double seconds = std::exp(chance.uniform(0, std::log(most_s)));
    const bool everybody = chance.happens(1.0 / 6);
    const double kind = chance.uniform(0, 1);
    const auto perhaps = [&](HostId host) {
        if (everybody || chance.happens(0.4)) block(host, kind < 0.75, kind < 0.5 || kind >= 0.75, seconds);
    };
    for (std::size_t i = 0; i < workers_.size(); ++i) perhaps(host_of_worker(i));
    for (std::size_t i = 0; i < clients_.size(); ++i) perhaps(host_of_client(i));
    for (std::size_t i = 0; i < relays_.size(); ++i) perhaps(host_of_relay(i));
}

void Farm::block(HostId host, bool to_master, bool to_peer, double seconds) {
    trouble(host, now_s() + seconds);
    if (to_master) world_.network.block(host, Side::master, seconds);
    if (to_peer) world_.network.block(host, Side::peer, seconds);
    for (SimulatedRelay& relay : relays_) {
        if (to_master) relay.below().block(host, Side::master, seconds);
        if (to_peer) relay.below().block(host, Side::peer, seconds);
    }
}

}  // namespace lumenfarm::testing
