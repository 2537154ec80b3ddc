#include "cli/verification.h"

#include "common/support/counted.h"
#include "common/transport/hit.h"

#include <algorithm>
#include <mutex>
#include <thread>
#include <utility>

namespace lumenfarm {
namespace {

constexpr std::uint64_t block = 64;  ///< particles of one batch that follow each other (batch_of())
constexpr std::uint64_t blocks_at_once = 64;
static_assert(block * limits::batches == 2'048);

/// Ranges of committed particles of some batches, given out to threads.
class Work {
public:
    Work(const std::vector<IntervalSet>& committed, const std::vector<std::uint32_t>& batches) : batches_(batches) {
        for (std::uint32_t light = 0; light < committed.size(); ++light)
            for (const auto& interval : committed[light].intervals()) {
                left_.push_back({light, interval.begin, interval.end - interval.begin});
                particles_ += interval.end - interval.begin;
            }
        std::reverse(left_.begin(), left_.end());
    }
    /// Empty when nothing is left.
    std::vector<ParticleRange> take() {
        const std::lock_guard lock(mutex_);
        std::vector<ParticleRange> taken;
        while (taken.size() < blocks_at_once && !left_.empty()) {
            ParticleRange& first = left_.back();
            const std::uint64_t count = std::min(first.count, block - first.first % block);
            if (std::binary_search(batches_.begin(), batches_.end(), batch_of(first.first)))
                taken.push_back({first.source, first.first, count});
            first.first += count;
            first.count -= count;
            passed_ += count;
            if (first.count == 0) left_.pop_back();
        }
        return taken;
    }
    double done() {
        const std::lock_guard lock(mutex_);
        return particles_ == 0 ? 1 : static_cast<double>(passed_) / static_cast<double>(particles_);
    }

private:
    std::vector<std::uint32_t> batches_;
    std::mutex mutex_;
    std::vector<ParticleRange> left_;  ///< of all batches, the next at the end
    std::uint64_t particles_ = 0, passed_ = 0;
};

/// What was traced, added up as a master does.
struct Found {
    Found(const LoadedRun& run) : sums(run.layout) {}
    LightMap sums;
    std::vector<KeptHit> kept;
    EnergyBalance balance;
};

class Verifier {
public:
    Verifier(const LoadedRun& run, const TracerScene& tracer, std::vector<std::uint32_t> batches)
        : run_(run), tracer_(tracer), work_(run.solution.committed, batches), found_(run) {
        verification_.batches = std::move(batches);
        const auto& kept = run.solution.kept;
        // one that is full keeps nothing beyond its last hit
        if (kept.size() >= run.solution.spec.keep_hits) last_priority_ = kept.empty() ? 0 : keep_priority(kept.back());
    }

    void trace(unsigned threads, const std::function<void(double)>& progress) {
        std::vector<std::jthread> workers;
        for (unsigned i = 0; i < threads; ++i) workers.emplace_back([&] { trace_some(progress); });
    }
    Verification compare() {
        verification_.particles = found_.balance.particles;
        verification_.hits = found_.balance.hits;
        compare_surfaces();
        compare_emission();
        compare_kept();
        if (verification_.batches.size() == limits::batches) compare_all();
        return std::move(verification_);
    }

private:
    void trace_some(const std::function<void(double)>& progress) {
        TracedHits hits;
        for (auto ranges = work_.take(); !ranges.empty(); ranges = work_.take()) {
            for (const ParticleRange& range : ranges) {
                hits.clear();
                tracer_.trace(run_.solution.spec, range, hits);
                add(range.source, hits);
            }
            const std::lock_guard lock(mutex_);
            progress(work_.done());
        }
    }
    void add(std::uint32_t light, const TracedHits& hits) {
        const std::lock_guard lock(mutex_);
        found_.sums.add(tracer_.emission(), light, hits.records, hits.energies);
        found_.balance += hits.balance;
        if (run_.solution.spec.keep_hits == 0) return;
        const auto& energy_of_bin = tracer_.emission().lights[light].energy;
        for (std::size_t i = 0; i < hits.records.size(); ++i) {
            const HitRecord& record = hits.records[i];
            const KeptHit hit{record, light,
                              hits.energies.empty() ? energy_of_bin[record.wavelength] : hits.energies[i]};
            if (keep_priority(hit) <= last_priority_) found_.kept.push_back(hit);
        }
    }

    void differs(std::string sentence) {
        if (verification_.differences.size() < verification_differences_max) {
            verification_.differences.push_back(std::move(sentence));
        } else {
            ++verification_.more_differences;
        }
    }
    void compare_surfaces() {
        const auto& said = run_.solution.surfaces;
        for (std::size_t surface = 0; surface < said.size(); ++surface)
            for (const std::uint32_t side : {0u, 1u})
                for (const std::uint32_t batch : verification_.batches) {
                    const BatchSums& theirs = said[surface][side][batch];
                    const BatchSums& ours = found_.sums.surfaces()[surface][side][batch];
                    if (theirs == ours) continue;
                    differs("surface '" + run_.scene.surfaces[surface].name + "' (" + (side == 0 ? "front" : "back") +
                            ") has " + std::to_string(theirs.hits) + " hits with " + std::to_string(theirs.radiant) +
                            " ticks of batch " + std::to_string(batch) + "; its particles give " +
                            std::to_string(ours.hits) + " hits with " + std::to_string(ours.radiant) + " ticks");
                }
    }
    void compare_emission() {
        for (const std::uint32_t batch : verification_.batches) {
            const std::int64_t theirs = run_.solution.balance.emitted_by_batch[batch];
            const std::int64_t ours = found_.balance.emitted_by_batch[batch];
            if (theirs != ours)
                differs("the lights emit " + std::to_string(theirs) + " ticks in batch " + std::to_string(batch) +
                        "; its particles carry " + std::to_string(ours));
        }
    }
    void compare_kept() {
        std::vector<KeptHit> said;
        for (const KeptHit& hit : run_.solution.kept)
            if (std::binary_search(verification_.batches.begin(), verification_.batches.end(), hit.record.batch()))
                said.push_back(hit);
        KeptHits ours(found_.kept.size());
        for (const KeptHit& hit : found_.kept) ours.offer(hit);
        std::vector<KeptHit> traced = ours.sorted();
        // of several hits with the last priority some may have found no room
        while (traced.size() > said.size() && keep_priority(traced.back()) == last_priority_) traced.pop_back();
        if (traced != said)
            differs(std::to_string(said.size()) +
                    " hits of these particles are kept; not all of them, or others, are "
                    "among those that they leave");
    }
    void compare_all() {
        const Solution& said = run_.solution;
        std::uint64_t texels = 0;
        for (std::size_t i = 0; i < said.texels.size(); ++i) texels += said.texels[i] != found_.sums.texels()[i];
        if (texels > 0) differs("the sums of " + counted(texels, "texel") + " are not those of the particles");
        if (said.balance != found_.balance) differs("the energy balance is not that of the particles");
    }

    const LoadedRun& run_;
    const TracerScene& tracer_;
    Work work_;
    std::mutex mutex_;  ///< of what follows, while it is traced
    Found found_;
    std::uint64_t last_priority_ = ~std::uint64_t{0};
    Verification verification_;
};

}  // namespace

Verification verify(const LoadedRun& run, const TracerScene& tracer, std::vector<std::uint32_t> batches,
                    unsigned threads, const std::function<void(double)>& progress) {
    Verifier verifier(run, tracer, std::move(batches));
    verifier.trace(threads, progress);
    return verifier.compare();
}

}  // namespace lumenfarm
