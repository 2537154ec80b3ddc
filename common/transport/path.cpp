#include "common/transport/path.h"

namespace lumenfarm {

std::vector<SurfaceFacts> surface_facts(const Scene& scene, const RayQuery& query) {
    std::vector<SurfaceFacts> facts;
    facts.reserve(scene.surfaces.size());
    for (const Surface& surface : scene.surfaces) {
        double longest = 0;
        for (std::uint32_t t = surface.first_triangle; t < surface.first_triangle + surface.triangle_count; ++t) {
            const auto& c = query.triangles()[t].corners;
            for (std::size_t k = 0; k < 3; ++k)
                longest = std::max(longest, length((c[(k + 1) % 3] - c[k]).as<double>()));
        }
        facts.push_back({&scene.materials[surface.material], query.near_edge_m() * longest});
    }
    return facts;
}

}  // namespace lumenfarm
