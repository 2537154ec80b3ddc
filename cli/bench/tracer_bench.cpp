#include "cli/bench/tracer_bench.h"

#include "cli/bench/median.h"
#include "common/service/thread_time.h"
#include "common/support/ensure.h"
#include "common/transport/ray_log.h"
#include "common/transport/tracer.h"

#include <algorithm>
#include <vector>

namespace lumenfarm {
namespace {

constexpr std::uint64_t rays_wanted = 2'000'000;
constexpr std::uint64_t trial_particles = 1'000;
constexpr std::uint64_t particles_max = 50'000'000;
constexpr std::uint64_t slice = 1'000;  // particles whose hits are held at a time, as a worker does

template <class Work>
double seconds_of(Work work) {
    const double begin = thread_cpu_seconds();
    work();
    return thread_cpu_seconds() - begin;
}

std::uint32_t brightest_light(const Emission& emission) {
    const auto& lights = emission.lights;
    const auto most = std::max_element(lights.begin(), lights.end(),
                                       [](const auto& a, const auto& b) { return a.flux_w < b.flux_w; });
    return static_cast<std::uint32_t>(most - lights.begin());
}

class TracerRounds {
public:
    TracerRounds(const TracerScene& tracer, const JobSpec& spec) : tracer_(tracer), spec_(spec) {
        light_ = brightest_light(tracer.emission());
    }

    /// Rays of the first particles.
    RayLog record(std::uint64_t particles) {
        RayLog log;
        hits_.clear();
        tracer_.trace(spec_, {light_, 0, particles}, hits_, &log);
        return log;
    }
    std::uint64_t hits() const { return hits_.balance.hits; }
    void trace(std::uint64_t particles) {
        for (std::uint64_t first = 0; first < particles; first += slice) {
            hits_.clear();
            tracer_.trace(spec_, {light_, first, std::min(slice, particles - first)}, hits_);
        }
    }

private:
    const TracerScene& tracer_;
    const JobSpec& spec_;
    std::uint32_t light_ = 0;
    TracedHits hits_;
};

std::vector<RayQuery::BareRay> bare_rays(const RayLog& log) {
    constexpr float near = 1e-5f;  // of the ray's start, which lies on a triangle
    std::vector<RayQuery::BareRay> rays;
    rays.reserve(log.size());
    for (const Ray& ray : log) rays.push_back({ray.origin.as<float>(), ray.direction.as<float>(), near});
    return rays;
}

}  // namespace

Result<TracerBench> bench_tracer(const Scene& scene, std::uint64_t particles, std::uint32_t rounds,
                                 const std::string& isa) {
    ensure(rounds > 0, "a benchmark has rounds");
    if (particles > particles_max)
        return bad_input("particles is " + std::to_string(particles) + "; at most " + std::to_string(particles_max) +
                         " are traced here");
    const auto tracer = TracerScene::make(scene, isa);
    if (!tracer) return tracer.error();
    const JobSpec spec;
    TracerRounds traced(**tracer, spec);
    if (particles == 0) {
        const auto trial = std::max<std::uint64_t>(1, traced.record(trial_particles).size());
        particles = std::clamp<std::uint64_t>(rays_wanted * trial_particles / trial, 1, particles_max);
    }
    const auto rays = bare_rays(traced.record(particles));
    TracerBench bench;
    bench.hits_per_particle = static_cast<double>(traced.hits()) / static_cast<double>(particles);
    bench.rays = rays.size();
    bench.particles = particles;
    bench.triangles = scene.triangles.size();
    bench.isa = (*tracer)->isa();
    bench.rounds = rounds;

    const auto bare = (*tracer)->query().bare_scene(scene);
    std::uint64_t met = bare->intersect_all(rays);  // warms both up
    traced.trace(particles);
    std::vector<double> trace_s, embree_s, ratios;
    for (std::uint32_t round = 0; round < rounds; ++round) {
        embree_s.push_back(seconds_of([&] { met += bare->intersect_all(rays); }));
        trace_s.push_back(seconds_of([&] { traced.trace(particles); }));
        ratios.push_back(embree_s.back() / trace_s.back());
    }
    ensure(met > 0, "bare rays meet something");
    bench.rays_per_s = static_cast<double>(bench.rays) / median(trace_s);
    bench.embree_rays_per_s = static_cast<double>(bench.rays) / median(embree_s);
    bench.particles_per_s = static_cast<double>(particles) / median(trace_s);
    bench.ratio = median(ratios);
    return bench;
}

}  // namespace lumenfarm
