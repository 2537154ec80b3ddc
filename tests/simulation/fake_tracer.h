#pragma once

#include "common/support/ensure.h"
#include "common/transport/tracer.h"
#include "tests/simulation/small_scene.h"

#include <cstdlib>

/// A tracer of invented hits: as pure a function of (seed, light, particle) as the real one, and thousands of times as
/// quick.
namespace lumenfarm::testing {

class FakeTracer : public TracerScene {
public:
    /// REQUIRES: `scene` is small_scene().
    explicit FakeTracer(const Scene& scene) : scene_(scene), emission_(emission_of_small_scene()) {}

    const Scene& scene() const override { return scene_; }
    const Emission& emission() const override { return emission_; }
    std::string isa() const override { return "fake"; }
    Meeting meet(Vec3d, Vec3d, std::uint32_t) const override { return {}; }
    const RayQuery& query() const override {
        ensure(false, "nobody asks the fake tracer for its rays");
        std::abort();
    }

    void follow(const JobSpec&, std::uint32_t, std::span<const Flight>, TracedHits&) const override {
        ensure(false, "the fake tracer follows particles from their lights only");
    }
    void trace(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog*) const override {
        for (std::uint64_t i = range.first; i < range.first + range.count; ++i) trace_one(spec, range.source, i, hits);
    }

protected:
    /// Made once for thousands of farms.
    static const Emission& emission_of_small_scene() {
        static const Emission emission = make_emission(small_scene()).value();
        return emission;
    }

    static std::uint64_t mix(std::uint64_t x) {  // splitmix64
        x += 0x9e3779b97f4a7c15u;
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
        return x ^ (x >> 31);
    }

private:
    void trace_one(const JobSpec& spec, std::uint32_t light, std::uint64_t particle, TracedHits& hits) const {
        std::uint64_t random = mix(mix(spec.seed * 1'000 + light) ^ particle);
        const auto bin = static_cast<std::uint16_t>(random % wavelength_bins);
        const std::int64_t energy = emission_.lights[light].energy[bin];
        const auto bounces = static_cast<std::uint32_t>((random >> 32) % 4);
        for (std::uint32_t bounce = 0; bounce < bounces; ++bounce) {
            random = mix(random);
            HitRecord record;
            record.triangle = static_cast<std::uint32_t>(random % scene_.triangles.size());
            record.b1 = static_cast<std::uint16_t>(random >> 8 & 0x7fff);
            record.b2 = static_cast<std::uint16_t>(random >> 24 & 0x7fff);
            record.wavelength = bin;
            record.flags = hit_flags(bounce, batch_of(particle), static_cast<std::uint32_t>(random >> 63));
            hits.records.push_back(record);
            if (spec.absorption == Absorption::attenuate) hits.energies.push_back(static_cast<std::uint32_t>(energy));
        }
        EnergyBalance& balance = hits.balance;
        balance.emitted += energy;
        (bounces == 0 ? balance.escaped : balance.absorbed) += energy;
        balance.particles += 1;
        balance.hits += bounces;
        balance.emitted_by_batch[batch_of(particle)] += energy;
    }

    const Scene& scene_;
    const Emission& emission_;
};

}  // namespace lumenfarm::testing
