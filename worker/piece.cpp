#include "worker/piece.h"

#include <utility>

namespace lumenfarm {

namespace {

Result<Piece> make_part(std::span<const std::byte> bytes, const std::shared_ptr<const PlanContext>& plan,
                        const std::string& isa) {
    struct Held {
        std::shared_ptr<const PlanContext> plan;
        std::unique_ptr<PartTracer> tracer;  ///< over the plan's palette
    };
    auto part = decode_part(bytes, plan->plan);
    if (!part) return part.error();
    auto tracer = PartTracer::make(std::move(*part), plan->plan.palette.scene, plan->plan.extent, isa);
    if (!tracer) return tracer.error();
    const auto held = std::make_shared<Held>(Held{plan, std::move(*tracer)});
    return Piece{std::shared_ptr<const PartTracer>(held, held->tracer.get()), nullptr};
}

Result<Piece> make_whole(std::span<const std::byte> bytes, const ScenePlan& plan, const std::string& isa) {
    const auto scene = make_scene_context(bytes, isa, TracerScene::make);
    if (!scene) return scene.error();
    if (palette_of((*scene)->scene) != plan.palette || scene_extent((*scene)->scene) != plan.extent)
        return bad_input("the scene is not that of the plan");
    return Piece{nullptr, std::shared_ptr<const TracerScene>(*scene, (*scene)->tracer.get())};
}

}  // namespace

Result<Piece> make_piece(std::uint32_t subspace, std::span<const std::byte> bytes,
                         const std::shared_ptr<const PlanContext>& plan, const std::string& isa) {
    return subspace == none ? make_whole(bytes, plan->plan, isa) : make_part(bytes, plan, isa);
}

}  // namespace lumenfarm
