#include "common/transport/tracer.h"

#include "common/support/ensure.h"
#include "common/transport/bsdf.h"
#include "common/transport/launch.h"
#include "common/transport/path.h"
#include "common/transport/ray_query.h"
#include "common/transport/wide_registers.h"

#include <array>

namespace lumenfarm {
namespace {

class Tracer final : public TracerScene {
public:
    Tracer(const Scene& scene, Emission emission, std::unique_ptr<RayQuery> query)
        : scene_(&scene),
          emission_(std::move(emission)),
          query_(std::move(query)),
          materials_(scene),
          surfaces_(surface_facts(scene, *query_)) {}

    const Scene& scene() const override { return *scene_; }
    const Emission& emission() const override { return emission_; }
    std::string isa() const override { return query_->isa(); }
    const RayQuery& query() const override { return *query_; }
    void trace(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const override;
    Meeting meet(Vec3d origin, Vec3d direction, std::uint32_t from_triangle) const override;

private:
    void trace_range(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const;
    void trace_avx2(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const;
    void trace_baseline(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const;

    const bool wide_registers_ = has_wide_registers();
    const Scene* scene_;
    Emission emission_;
    std::unique_ptr<RayQuery> query_;
    MaterialTable materials_;
    std::vector<SurfaceFacts> surfaces_;
};

inline void Tracer::trace_range(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const {
    ensure(range.light < scene_->lights.size() && range.first + range.count <= limits::particles_max,
           "range is within the light");
    const Launcher launcher(*scene_, emission_, query_->triangles(), spec.seed, range.light);
    const PathRules rules(materials_, query_->triangles(), surfaces_, spec, range.light);
    std::array<Flight, flights_side_by_side> flights;
    std::array<RayAnswer, flights_side_by_side> answers;
    ScatterDraws draws;
    std::uint64_t next = range.first;
    const std::uint64_t end = range.first + range.count;
    std::uint32_t active = 0;
    const auto launch = [&](Flight& flight) {
        flight = rules.start(launcher, static_cast<std::uint32_t>(next++), hits.balance);
    };
    while (active < flights_side_by_side && next < end) launch(flights[active++]);
    while (active > 0) {
        for (std::uint32_t k = 0; k < active; ++k) {
            if (log) log->push_back(flights[k].ray);
            answers[k] = query_->nearest(flights[k].ray);
            if (answers[k].triangle != none) __builtin_prefetch(&query_->triangles()[answers[k].triangle]);
        }
        for (std::uint32_t k = 0; k < active; ++k) draws.set(k, flights[k].particle, range.light, flights[k].bounce);
        draws.draw(spec.seed);
        std::uint32_t kept = 0;
        for (std::uint32_t k = 0; k < active; ++k) {
            const bool goes_on = rules.advance(flights[k], answers[k], draws, k, hits);
            if (!goes_on && next == end) continue;
            if (!goes_on) launch(flights[k]);
            if (kept != k) flights[kept] = flights[k];
            ++kept;
        }
        active = kept;
    }
}

[[gnu::target("avx2,bmi,bmi2"), gnu::flatten]] void Tracer::trace_avx2(const JobSpec& spec, const ParticleRange& range,
                                                                       TracedHits& hits, RayLog* log) const {
    trace_range(spec, range, hits, log);
}

[[gnu::flatten]] void Tracer::trace_baseline(const JobSpec& spec, const ParticleRange& range, TracedHits& hits,
                                             RayLog* log) const {
    trace_range(spec, range, hits, log);
}

void Tracer::trace(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const {
    if (wide_registers_)
        trace_avx2(spec, range, hits, log);
    else
        trace_baseline(spec, range, hits, log);
}

TracerScene::Meeting Tracer::meet(Vec3d origin, Vec3d direction, std::uint32_t from_triangle) const {
    const double scale = length(direction);
    const Vec3d unit = direction * (1 / scale);
    const RayAnswer answer = query_->nearest({origin, unit, from_triangle, true});
    if (answer.triangle == none) return {};
    const TriangleMeeting meeting = meet_triangle(query_->triangles()[answer.triangle], origin, unit);
    return {answer.triangle, meeting.distance / scale, meeting.b1, meeting.b2,
            dot(query_->triangles()[answer.triangle].normal, unit) > 0};
}

}  // namespace

EnergyBalance& EnergyBalance::operator+=(const EnergyBalance& other) {
    emitted += other.emitted;
    absorbed += other.absorbed;
    escaped += other.escaped;
    cut_off += other.cut_off;
    particles += other.particles;
    hits += other.hits;
    bounce_limited += other.bounce_limited;
    for (std::size_t b = 0; b < emitted_by_batch.size(); ++b) emitted_by_batch[b] += other.emitted_by_batch[b];
    return *this;
}

void TracedHits::clear() {
    records.clear();
    energies.clear();
    balance = {};
}

Result<std::unique_ptr<TracerScene>> TracerScene::make(const Scene& scene, const std::string& isa) {
    auto emission = make_emission(scene);
    if (!emission) return emission.error();
    auto query = RayQuery::make(scene, isa);
    if (!query) return query.error();
    return std::unique_ptr<TracerScene>(
        std::make_unique<Tracer>(scene, std::move(emission.value()), std::move(query.value())));
}

}  // namespace lumenfarm
