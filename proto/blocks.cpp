#include "proto/blocks.h"

#include "common/spectrum/spectrum.h"

#include <bit>
#include <cmath>

namespace lumenfarm::wire {
namespace {

std::array<std::uint64_t, 3> bits_of(Vec3d v) {
    return {std::bit_cast<std::uint64_t>(v.x), std::bit_cast<std::uint64_t>(v.y), std::bit_cast<std::uint64_t>(v.z)};
}
Vec3d from_bits(const std::array<std::uint64_t, 3>& bits) {
    return {std::bit_cast<double>(bits[0]), std::bit_cast<double>(bits[1]), std::bit_cast<double>(bits[2])};
}

}  // namespace

FlightRecord pack_flight(const Flight& flight, std::uint32_t light) {
    FlightRecord record;
    record.origin = bits_of(flight.origin);
    record.direction = bits_of(flight.direction);
    record.travelled = std::bit_cast<std::uint64_t>(flight.travelled_m);
    record.from_triangle = flight.from_triangle;
    record.light = light;
    record.particle = flight.particle;
    record.energy = flight.energy;
    record.start_energy = flight.start_energy;
    record.bounce = static_cast<std::uint16_t>(flight.bounce);
    record.wavelength = static_cast<std::uint16_t>(flight.wavelength);
    return record;
}

Flight unpack_flight(const FlightRecord& record) {
    Flight flight;
    flight.origin = from_bits(record.origin);
    flight.direction = from_bits(record.direction);
    flight.travelled_m = std::bit_cast<double>(record.travelled);
    flight.from_triangle = record.from_triangle;
    flight.particle = record.particle;
    flight.bounce = record.bounce;
    flight.wavelength = record.wavelength;
    flight.energy = record.energy;
    flight.start_energy = record.start_energy;
    return flight;
}

bool possible_flight(const FlightRecord& record) {
    const Flight flight = unpack_flight(record);
    const auto within = [&](double v) { return std::abs(v) <= farthest_m; };
    const Vec3d o = flight.origin, d = flight.direction;
    return within(o.x) && within(o.y) && within(o.z) && std::abs(dot(d, d) - 1) <= 1e-6 && flight.travelled_m >= 0 &&
           within(flight.travelled_m) && record.light < limits::lights_max && record.bounce < limits::bounces_max &&
           record.wavelength < wavelength_bins && record.energy > 0 && record.energy <= limits::energy_ticks_max &&
           record.start_energy > 0 && record.start_energy <= limits::energy_ticks_max;
}

}  // namespace lumenfarm::wire
