#include "common/transport/fingerprint.h"

#include "common/support/digest.h"
#include "common/transport/tracer.h"

#include <cstring>
#include <span>

namespace lumenfarm {

namespace {

constexpr std::uint64_t particles_of_the_trace = 512;

/// A luminous square over three tilted ones: grey, mirror, glass.
Scene built_in_scene() {
    Scene scene;
    scene.spectra = {constant_spectrum(0.5), constant_spectrum(1), constant_spectrum(1.5)};
    Material grey, mirror, glass;
    grey.name = "grey";
    grey.diffuse.spectrum = 0;
    mirror.name = "mirror";
    mirror.mirror.spectrum = 0;
    glass.name = "glass";
    glass.dielectric = 1;
    glass.transmission.spectrum = 1;
    glass.refractive_index = 2;
    scene.materials = {grey, mirror, glass};
    const auto add_square = [&](const char* name, float y, float slope, std::uint32_t material) {
        const auto first = static_cast<std::uint32_t>(scene.positions.size());
        scene.positions.insert(scene.positions.end(), {{-1, y, -1}, {1, y + slope, -1}, {1, y + slope, 1}, {-1, y, 1}});
        scene.surfaces.push_back({name, name, static_cast<std::uint32_t>(scene.triangles.size()), 2, material});
        scene.triangles.push_back({first, first + 1, first + 2});
        scene.triangles.push_back({first, first + 2, first + 3});
    };
    add_square("lamp", 2, 0, 0);
    add_square("pane", 1, 0.3f, 2);
    add_square("floor", 0, 0.1f, 0);
    add_square("looking-glass", -1, 0.2f, 1);
    Light lamp;
    lamp.name = "lamp";
    lamp.spectrum = 1;
    lamp.photometric = 100;
    lamp.surface = 0;
    scene.lights = {lamp};
    return scene;
}

}  // namespace

Result<std::uint64_t> transport_fingerprint(const std::string& isa) {
    const Scene scene = built_in_scene();
    const auto tracer = TracerScene::make(scene, isa);
    if (!tracer) return tracer.error();
    Sha256 hash;
    for (const Absorption absorption : {Absorption::analog, Absorption::attenuate}) {
        JobSpec spec;
        spec.particles = particles_of_the_trace;
        spec.absorption = absorption;
        TracedHits hits;
        (*tracer)->trace(spec, {0, 0, particles_of_the_trace}, hits);
        hash.update(std::as_bytes(std::span(hits.records)));
        hash.update(std::as_bytes(std::span(hits.energies)));
    }
    const Digest digest = hash.finish();
    std::uint64_t fingerprint = 0;
    std::memcpy(&fingerprint, digest.bytes.data(), sizeof fingerprint);
    return fingerprint;
}

Result<std::uint64_t> farm_fingerprint(const std::string& isa, bool paced_workers) {
    const auto fingerprint = transport_fingerprint(isa);
    return fingerprint && paced_workers ? paced_fingerprint(*fingerprint) : fingerprint;
}

}  // namespace lumenfarm
