#include "common/solution/solution.h"

#include <xxhash.h>

#include <algorithm>
#include <limits>
#include <tuple>
#include <type_traits>

namespace lumenfarm {
namespace {

auto content(const KeptHit& hit) {
    const HitRecord& r = hit.record;
    return std::tuple(hit.light, r.triangle, r.b1, r.b2, r.direction_u, r.direction_v, r.wavelength, r.flags,
                      hit.energy);
}

}  // namespace

static_assert(sizeof(KeptHit) == 24 && std::has_unique_object_representations_v<KeptHit>);

std::uint64_t keep_priority(const KeptHit& hit) { return XXH3_64bits(&hit, sizeof hit); }

bool KeptHits::before(const Entry& a, const Entry& b) {
    if (a.priority != b.priority) return a.priority < b.priority;
    return content(a.hit) < content(b.hit);
}

void KeptHits::offer(const KeptHit& hit) {
    if (capacity_ == 0) return;
    const Entry entry{keep_priority(hit), hit};
    if (heap_.size() == capacity_) {
        if (!before(entry, heap_.front())) return;
        std::pop_heap(heap_.begin(), heap_.end(), before);
        heap_.back() = entry;
    } else {
        heap_.push_back(entry);
    }
    std::push_heap(heap_.begin(), heap_.end(), before);
}

std::uint64_t KeptHits::threshold() const {
    if (capacity_ == 0) return 0;
    return heap_.size() < capacity_ ? std::numeric_limits<std::uint64_t>::max() : heap_.front().priority;
}

std::vector<KeptHit> KeptHits::sorted() const {
    std::vector<Entry> entries = heap_;
    std::sort(entries.begin(), entries.end(), before);
    std::vector<KeptHit> hits;
    hits.reserve(entries.size());
    for (const Entry& entry : entries) hits.push_back(entry.hit);
    return hits;
}

}  // namespace lumenfarm
