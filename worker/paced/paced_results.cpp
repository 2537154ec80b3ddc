#include "worker/paced/paced_results.h"

#include "common/scene/scene_file.h"
#include "common/support/ensure.h"

#include <algorithm>
#include <bit>
#include <filesystem>
#include <utility>

namespace lumenfarm::worker {

namespace {

constexpr std::uint64_t sums_bytes_max = std::uint64_t{1} << 30;
constexpr std::uint64_t bytes_as_long_as_a_particle = 128;  ///< of a map take as long to be added as its hits, about

}  // namespace

PacedResults::PacedResults(StoredJob job, std::shared_ptr<const SceneContext> scene, StoredHits stored)
    : job_(std::move(job)), scene_(std::move(scene)), stored_(std::move(stored)) {
    for (std::uint32_t light = 0; light < scene_->tracer->emission().lights.size(); ++light) {
        std::uint64_t hits = 0;
        for (std::uint64_t block = 0; block < stored_.particles() / StoredHits::block_particles; ++block)
            hits += stored_.block(light, block).records.size();
        hits_per_particle_.push_back(static_cast<double>(hits) / static_cast<double>(stored_.particles()));
    }
}

Result<std::shared_ptr<const PacedResults>> PacedResults::make(std::span<const std::byte> scene_bytes,
                                                               const JobSpec& spec, const std::filesystem::path& file,
                                                               const std::string& isa) {
    if (auto good = validate(spec); !good) return good.error();
    if (spec.strategy == Strategy::subspaces || spec.keep_hits > 0)
        return bad_input("paced workers have results of whole paths only: no --strategy subspaces, no --keep-hits");
    auto scene = make_scene_context(scene_bytes, isa, &TracerScene::make);
    if (!scene) return scene.error();
    if ((*scene)->tracer->emission().lights.size() > StoredHits::lights_max)
        return bad_input("paced workers know scenes of at most " + std::to_string(StoredHits::lights_max) + " lights");
    const StoredJob job{scene_digest(scene_bytes), spec};
    std::error_code ignored;
    const bool there = std::filesystem::exists(file, ignored);
    auto stored = there ? StoredHits::read(file, *(*scene)->tracer, job)
                        : Result<StoredHits>(StoredHits::trace(*(*scene)->tracer, job));
    if (!stored) return stored.error();
    if (!there)
        if (auto written = stored->write(file, job); !written) return written.error();
    const std::shared_ptr<PacedResults> results(new PacedResults(job, std::move(*scene), std::move(*stored)));
    if (spec.packing != Packing::records)
        if (auto added = results->add_up(spec); !added) return added.error();
    return std::shared_ptr<const PacedResults>(results);
}

/// Sums up to every step_-th particle; those of a range are the difference of two.
Result<void> PacedResults::add_up(const JobSpec& spec) {
    JobSpec maps = spec;
    maps.packing = Packing::maps;
    auto context =
        make_job_context({0, job_.scene, 0, maps, texel_in_force_m(spec, scene_->scene), 1}, scene_, nullptr);
    if (!context) return context.error();
    maps_ = std::move(*context);
    const Sums zero{maps_->empty_map(), {}};
    scratch_ = std::make_unique<ScratchMaps>(zero.map);
    const std::uint64_t bytes =
        zero.map.texels().size() * sizeof(TexelSums) + zero.map.surfaces().size() * sizeof(SurfaceBatches);
    if (maps_->lights() * bytes > sums_bytes_max / 2)
        return bad_input("the light maps are too large for paced workers; say a larger --texel, or --packing records");
    step_ = std::clamp(std::bit_ceil(bytes / bytes_as_long_as_a_particle), StoredHits::block_particles,
                       stored_.particles());
    while (step_ < stored_.particles() && maps_->lights() * (stored_.particles() / step_) * bytes > sums_bytes_max)
        step_ *= 2;
    sums_.resize(maps_->lights());
    for (std::uint32_t light = 0; light < maps_->lights(); ++light) {
        Sums sums = zero;
        sums_[light].push_back(sums);
        for (std::uint64_t end = step_; end <= stored_.particles(); end += step_) {
            for_pieces(light, end - step_, end, [&](const TracedHits& hits) {
                sums.map.add(maps_->emission(), light, hits.records, hits.energies);
                sums.balance += hits.balance;
            });
            sums_[light].push_back(sums);
        }
    }
    return {};
}

Result<std::shared_ptr<const JobContext>> PacedResults::context_of(const wire::JobInfo& info) const {
    if (info.scene != job_.scene || !same_paths(info.spec, job_.spec) || info.spec.keep_hits > 0)
        return bad_input("the paced workers' results are of another job");
    auto context = make_job_context(info, scene_, nullptr);
    if (!context || info.spec.packing == Packing::records) return context;
    if (!maps_ || (*context)->layout->rows() != maps_->layout->rows())
        return bad_input("the paced workers' results have other texels");
    return context;
}

template <class Take>
void PacedResults::for_pieces(std::uint32_t light, std::uint64_t first, std::uint64_t end, const Take& take) const {
    while (first < end) {
        const std::uint64_t block = first / StoredHits::block_particles;
        const std::uint64_t last = std::min(end, (block + 1) * StoredHits::block_particles);
        if (last - first == StoredHits::block_particles) {
            take(stored_.block(light, block));
        } else {
            TracedHits hits;
            scene_->tracer->trace(job_.spec, {light, first, last - first}, hits);
            take(hits);
        }
        first = last;
    }
}

template <class Take>
void PacedResults::for_stretches(const ParticleRange& range, const Take& take) const {
    std::uint64_t first = range.first % stored_.particles();
    for (std::uint64_t left = range.count; left > 0;) {
        const std::uint64_t end = std::min(first + left, stored_.particles());
        take(first, end);
        left -= end - first;
        first = 0;
    }
}

void PacedResults::add_hits(const ParticleRange& range, Parcel& parcel) const {
    for_stretches(range, [&](std::uint64_t first, std::uint64_t end) {
        for_pieces(range.source, first, end, [&](const TracedHits& hits) {
            parcel.add_hits(range.source, hits.records, hits.energies);
            parcel.balance += hits.balance;
        });
    });
}

void PacedResults::add_stored(std::uint32_t light, std::uint64_t first, std::uint64_t end, LightMap& map,
                              EnergyBalance& balance, Terms& terms) const {
    const auto add_pieces = [&](std::uint64_t from, std::uint64_t to) {
        for_pieces(light, from, to, [&](const TracedHits& hits) {
            map.add(maps_->emission(), light, hits.records, hits.energies);
            balance += hits.balance;
        });
    };
    const std::uint64_t first_step = (first + step_ - 1) / step_, last_step = end / step_;
    if (first_step >= last_step || end - first < 4 * step_) return add_pieces(first, end);
    add_pieces(first, first_step * step_);
    terms[{light, last_step}] += 1;
    terms[{light, first_step}] -= 1;
    add_pieces(last_step * step_, end);
}

void PacedResults::add_sums(std::span<const wire::Claim> claims, Parcel& parcel) const {
    ensure(maps_ != nullptr, "sums are of a job whose texels are known");
    scratch_->with_map([&](LightMap& map) {
        Terms terms;
        for (const wire::Claim& claim : claims) {
            ParticleRange range = claim.range;
            terms[{range.source, sums_[range.source].size() - 1}] +=
                static_cast<std::int64_t>(range.count / stored_.particles());
            range.count %= stored_.particles();
            for_stretches(range, [&](std::uint64_t first, std::uint64_t end) {
                add_stored(range.source, first, end, map, parcel.balance, terms);
            });
        }
        std::vector<LightMap::Term> maps;
        for (const auto& [place, times] : terms) {
            const Sums& of = sums_[place.first][place.second];
            if (times != 0) maps.push_back({&of.map, times});
            parcel.balance.add(of.balance, times);
        }
        map.add(maps);
        move_sums(map, parcel);
    });
}

}  // namespace lumenfarm::worker
