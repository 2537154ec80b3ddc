#include "common/transport/scene_in_parts.h"

#include <utility>

namespace lumenfarm {

Result<std::unique_ptr<SceneInParts>> SceneInParts::make(const Scene& scene, Subspaces cut, std::uint32_t places) {
    auto made =
        std::make_unique<SceneInParts>(SceneInParts{std::move(cut), palette_of(scene), scene_extent(scene), {}, 0});
    std::vector<std::vector<std::shared_ptr<const PartTracer>>> held(
        places, std::vector<std::shared_ptr<const PartTracer>>(made->subspaces.all().size()));
    std::uint32_t subspace = 0;
    for (const auto& filed : made->subspaces.triangles(scene, part_margin_m(made->extent))) {
        ScenePart part = part_of(scene, filed);
        made->triangles += part.numbers.size();
        auto tracer = PartTracer::make(std::move(part), made->palette.scene, made->extent);
        if (!tracer) return tracer.error();
        held[subspace % places][subspace] = std::move(*tracer);
        ++subspace;
    }
    for (auto& place : held) made->territories.emplace_back(made->subspaces.partition(), std::move(place));
    return made;
}

}  // namespace lumenfarm
