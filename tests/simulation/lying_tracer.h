#pragma once

#include "tests/simulation/fake_tracer.h"

/// A tracer on a machine whose memory flips a bit now and then: what it says looks possible, and is wrong.
namespace lumenfarm::testing {

class LyingTracer : public FakeTracer {
public:
    /// `one_in`: slices of a set, of which one is wrong.
    LyingTracer(const Scene& scene, std::uint64_t one_in) : FakeTracer(scene), one_in_(one_in) {}

    void trace(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const override {
        const std::size_t before = hits.records.size();
        FakeTracer::trace(spec, range, hits, log);
        if (mix(range.first) % one_in_ == 0 && hits.records.size() > before) hits.records[before].b1 ^= 1u << 14;
    }

private:
    std::uint64_t one_in_;
};

}  // namespace lumenfarm::testing
