#pragma once

#include "common/scene/job_spec.h"
#include "common/support/digest.h"
#include "common/support/limits.h"
#include "common/transport/tracer.h"
#include "proto/archive.h"

/// How types of the other rooms travel. In their namespace, where argument-dependent lookup finds them.
namespace lumenfarm {

constexpr Absorption enum_last(Absorption) { return Absorption::attenuate; }
constexpr CutoffRule enum_last(CutoffRule) { return CutoffRule::plain; }
constexpr Strategy enum_last(Strategy) { return Strategy::subspaces; }
constexpr Packing enum_last(Packing) { return Packing::maps; }

template <class Archive>
void serialize(Archive& ar, Digest& digest, unsigned) {
    wire::fields(ar, digest.bytes);
}

template <class Archive>
void serialize(Archive& ar, ParticleRange& range, unsigned) {
    wire::fields(ar, range.source, range.first, range.count);
}

template <class Archive>
void serialize(Archive& ar, EnergyBalance& balance, unsigned) {
    wire::fields(ar, balance.emitted, balance.absorbed, balance.escaped, balance.cut_off, balance.particles,
                 balance.hits, balance.bounce_limited, balance.emitted_by_batch);
}

/// The master also checks it with validate().
template <class Archive>
void serialize(Archive& ar, JobSpec& spec, unsigned) {
    wire::fields(ar, spec.particles, spec.seed, spec.absorption, spec.cutoff_rule, spec.cutoff, spec.texel_m,
                 spec.keep_hits, spec.strategy, spec.subspaces, spec.packing, spec.particles_per_set,
                 spec.hits_per_message, wire::at_most(spec.name, limits::name_bytes_max), spec.priority);
}

namespace wire {

/// Not empty, and its source and particles within the limits of any job.
constexpr bool valid_range(const ParticleRange& range) {
    return range.source < limits::lights_max + limits::subspaces_max && range.count > 0 &&
           range.count <= limits::particles_per_set_max && range.first <= limits::particles_max - range.count;
}

}  // namespace wire
}  // namespace lumenfarm
