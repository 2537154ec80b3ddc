#include "common/solution/solution.h"

#include "common/support/bytes.h"

#include <type_traits>

namespace lumenfarm {
namespace {

// The sums are hashed as they lie in memory, so no byte of them may be padding.
static_assert(std::has_unique_object_representations_v<TexelSums>);
static_assert(std::has_unique_object_representations_v<SurfaceBatches>);

void add_spec(ByteWriter& out, const JobSpec& spec) {
    out.value(spec.particles);
    out.value(spec.seed);
    out.value(spec.absorption);
    if (spec.absorption == Absorption::attenuate) {  // analog paths know no cut-off
        out.value(spec.cutoff_rule);
        out.value(spec.cutoff);
    }
    out.value(spec.texel_m);
    out.value(spec.keep_hits);
}

void add_committed(ByteWriter& out, const std::vector<IntervalSet>& committed) {
    out.value(static_cast<std::uint64_t>(committed.size()));
    for (const IntervalSet& set : committed) {
        const std::vector<IntervalSet::Interval> intervals = set.intervals();
        out.block(std::span<const IntervalSet::Interval>(intervals));
    }
}

void add_balance(ByteWriter& out, const EnergyBalance& balance) {
    for (const std::int64_t ticks : {balance.emitted, balance.absorbed, balance.escaped, balance.cut_off})
        out.value(ticks);
    for (const std::uint64_t count : {balance.particles, balance.hits, balance.bounce_limited}) out.value(count);
    for (const std::int64_t ticks : balance.emitted_by_batch) out.value(ticks);
}

template <class T>
void update(Sha256& sha, const std::vector<T>& elements) {
    const std::uint64_t count = elements.size();
    sha.update(std::as_bytes(std::span(&count, 1)));
    sha.update(std::as_bytes(std::span(elements)));
}

}  // namespace

Digest solution_digest(const Solution& solution) {
    ByteWriter head;
    head.text("lumenfarm solution 1");
    for (const std::uint8_t byte : solution.scene.bytes) head.value(byte);
    add_spec(head, solution.spec);
    add_committed(head, solution.committed);
    add_balance(head, solution.balance);
    Sha256 sha;
    sha.update(head.bytes());
    update(sha, solution.texels);
    update(sha, solution.surfaces);
    update(sha, solution.kept);
    return sha.finish();
}

}  // namespace lumenfarm
