#include "common/transport/emitter.h"

#include "common/transport/hit.h"
#include "common/transport/launch.h"

namespace lumenfarm {
namespace {

std::vector<TriangleRecord> triangles_of(const Scene& scene, const Light& light) {
    std::vector<TriangleRecord> records;
    if (light.kind != LightKind::surface) return records;
    const Surface& surface = scene.surfaces[light.surface];
    for (std::uint32_t t = 0; t < surface.triangle_count; ++t)
        records.push_back(triangle_record(scene, surface.first_triangle + t, light.surface));
    return records;
}

}  // namespace

Emitter::Emitter(const ScenePart& palette, const Emission& emission, const Partition& partition,
                 const SceneExtent& extent)
    : palette_(palette), emission_(emission), partition_(partition), extent_(extent) {
    for (const Light& light : palette.scene.lights) triangles_.push_back(triangles_of(palette.scene, light));
}

void Emitter::emit(std::uint64_t seed, const ParticleRange& range, std::vector<Departure>& departures,
                   EnergyBalance& balance) const {
    const Launcher launcher(palette_.scene, emission_, extent_, triangles_[range.source].data(), clear_nowhere_, seed,
                            range.source);
    LaunchLanes launched;
    for (std::uint64_t particle = range.first; particle < range.first + range.count; ++particle) {
        const std::size_t lane = particle % lane_count;
        if (lane == 0 || particle == range.first)
            launcher.launch(static_cast<std::uint32_t>(particle - lane), launched);
        const std::uint32_t energy = launched.energy[lane];
        book_emission(balance, static_cast<std::uint32_t>(particle), energy);
        Flight flight;
        flight.origin = launched.rays.origin.at(lane);
        flight.direction = launched.rays.direction.at(lane);
        const std::uint32_t from = launched.rays.from_triangle[lane];
        flight.from_triangle = from == none ? none : palette_.numbers[from];
        flight.particle = static_cast<std::uint32_t>(particle);
        flight.wavelength = launched.wavelength[lane];
        flight.energy = flight.start_energy = energy;
        depart(flight, partition_.at(flight.origin, flight.direction, 0), departures, balance);
    }
}

}  // namespace lumenfarm
