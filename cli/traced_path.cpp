#include "cli/traced_path.h"

#include "common/support/ensure.h"
#include "common/transport/ray_log.h"

namespace lumenfarm {
namespace {

/// True when both directions point to the same side of the triangle.
bool passes_through(const TriangleRecord& triangle, Vec3d before, Vec3d after) {
    const Vec3d normal = unit_normal(triangle);
    return (dot(normal, before) > 0) == (dot(normal, after) > 0);
}

}  // namespace

TracedPath trace_path(const TracerScene& tracer, const JobSpec& spec, std::uint32_t light, std::uint64_t particle) {
    TracedHits traced;
    RayLog rays;
    tracer.trace(spec, {light, particle, 1}, traced, &rays);
    const std::size_t hits = traced.records.size();
    const bool escapes = rays.size() == hits + 1;
    ensure(!rays.empty() && (escapes || rays.size() == hits), "each ray of a path ends in a hit, but perhaps the last");

    TracedPath path;
    path.particle = particle;
    path.wavelength = rays.front().wavelength;
    path.energy = rays.front().energy;
    path.position = rays.front().origin;
    path.direction = rays.front().direction;
    path.balance = traced.balance;
    if (escapes) path.escaped = rays.back().direction;
    for (std::size_t i = 0; i < hits; ++i) {
        const LoggedRay& ray = rays[i];
        const LoggedRay* next = i + 1 < rays.size() ? &rays[i + 1] : nullptr;
        PathHit hit;
        hit.record = traced.records[i];
        const TriangleRecord& triangle = tracer.query().triangles()[hit.record.triangle];
        hit.surface = triangle.surface;
        hit.direction = ray.direction;
        hit.energy = ray.energy;
        hit.absorbed = (next ? next->absorbed : traced.balance.absorbed) - ray.absorbed;
        hit.cut_off = (next ? next->cut_off : traced.balance.cut_off) - ray.cut_off;
        if (next) {
            hit.fate =
                passes_through(triangle, ray.direction, next->direction) ? HitFate::transmitted : HitFate::reflected;
        } else if (traced.balance.bounce_limited > 0) {
            hit.fate = HitFate::bounce_limit;
        } else if (hit.cut_off > 0) {
            hit.fate = HitFate::cut_off;
        }
        path.hits.push_back(hit);
    }
    return path;
}

}  // namespace lumenfarm
