#include "common/transport/tracer.h"

#include "common/support/ensure.h"
#include "common/transport/bsdf.h"
#include "common/transport/follow.h"
#include "common/transport/wide_registers.h"

#include <vector>

namespace lumenfarm {
namespace {

class Tracer final : public TracerScene {
public:
    Tracer(const Scene& scene, Emission emission, std::unique_ptr<RayQuery> query)
        : scene_(&scene),
          emission_(std::move(emission)),
          query_(std::move(query)),
          materials_(scene),
          surface_materials_(materials_by_surface(scene, scene)) {}

    const Scene& scene() const override { return *scene_; }
    const Emission& emission() const override { return emission_; }
    std::string isa() const override { return query_->isa(); }
    const RayQuery& query() const override { return *query_; }
    void follow(const JobSpec& spec, std::uint32_t light, std::span<const Flight> flights,
                TracedHits& hits) const override;
    void trace(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const override;
    Meeting meet(Vec3d origin, Vec3d direction, std::uint32_t from_triangle) const override;

private:
    void trace_range(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const;
    void trace_avx2(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const;
    void trace_baseline(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const;
    void follow_avx2(const PathRules& rules, Arrivals& arrivals, TracedHits& hits) const;
    void follow_baseline(const PathRules& rules, Arrivals& arrivals, TracedHits& hits) const;

    const bool wide_registers_ = has_wide_registers();
    const Scene* scene_;
    Emission emission_;
    std::unique_ptr<RayQuery> query_;
    MaterialTable materials_;
    std::vector<const Material*> surface_materials_;
};

inline void Tracer::trace_range(const JobSpec& spec, const ParticleRange& range, TracedHits& hits, RayLog* log) const {
    ensure(range.source < scene_->lights.size() && range.first + range.count <= limits::particles_max,
           "range is within the light");
    const Light& light = scene_->lights[range.source];
    const TriangleRecord* triangles =
        query_->triangles().data() +
        (light.kind == LightKind::surface ? scene_->surfaces[light.surface].first_triangle : 0);
    const Launcher launcher(*scene_, emission_, query_->extent(), triangles, query_->clearance(), spec.seed,
                            range.source);
    const PathRules rules(materials_, query_->triangles(), surface_materials_, spec, range.source);
    Queue queue(launcher, rules, range);
    WholeScene everywhere;
    lumenfarm::follow(*query_, rules, queue, everywhere, hits, log);
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

[[gnu::target("avx2,bmi,bmi2"), gnu::flatten]] void Tracer::follow_avx2(const PathRules& rules, Arrivals& arrivals,
                                                                        TracedHits& hits) const {
    WholeScene everywhere;
    lumenfarm::follow(*query_, rules, arrivals, everywhere, hits, nullptr);
}

[[gnu::flatten]] void Tracer::follow_baseline(const PathRules& rules, Arrivals& arrivals, TracedHits& hits) const {
    WholeScene everywhere;
    lumenfarm::follow(*query_, rules, arrivals, everywhere, hits, nullptr);
}

void Tracer::follow(const JobSpec& spec, std::uint32_t light, std::span<const Flight> flights, TracedHits& hits) const {
    const PathRules rules(materials_, query_->triangles(), surface_materials_, spec, light);
    Arrivals arrivals(flights, nullptr);
    if (wide_registers_)
        follow_avx2(rules, arrivals, hits);
    else
        follow_baseline(rules, arrivals, hits);
}

TracerScene::Meeting Tracer::meet(Vec3d origin, Vec3d direction, std::uint32_t from_triangle) const {
    const double scale = length(direction);
    const Vec3d unit = direction * (1 / scale);
    const std::uint32_t triangle = query_->nearest({origin, unit, from_triangle});
    if (triangle == none) return {};
    const TriangleRecord& record = query_->triangles()[triangle];
    const TriangleMeeting meeting = meet_triangle(record, origin, unit);
    return {triangle, meeting.distance / scale, meeting.b1, meeting.b2, dot(unit_normal(record), unit) > 0};
}

}  // namespace

EnergyBalance& EnergyBalance::add(const EnergyBalance& other, std::int64_t times) {
    const auto unsigned_times = static_cast<std::uint64_t>(times);
    emitted += times * other.emitted;
    absorbed += times * other.absorbed;
    escaped += times * other.escaped;
    cut_off += times * other.cut_off;
    particles += unsigned_times * other.particles;
    hits += unsigned_times * other.hits;
    bounce_limited += unsigned_times * other.bounce_limited;
    for (std::size_t b = 0; b < emitted_by_batch.size(); ++b) emitted_by_batch[b] += times * other.emitted_by_batch[b];
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
    auto query = RayQuery::make(scene, scene_extent(scene), isa);
    if (!query) return query.error();
    return std::unique_ptr<TracerScene>(
        std::make_unique<Tracer>(scene, std::move(emission.value()), std::move(query.value())));
}

}  // namespace lumenfarm
