#include "worker/job_context.h"

#include "common/scene/scene_file.h"

#include <utility>

namespace lumenfarm {

Result<std::shared_ptr<const SceneContext>> make_scene_context(std::span<const std::byte> scene_bytes,
                                                               const std::string& isa, const TracerMaker& make_tracer) {
    auto scene = decode_scene(scene_bytes);
    if (!scene) return scene.error();
    auto context = std::make_shared<SceneContext>();
    context->scene = std::move(*scene);
    auto tracer = make_tracer(context->scene, isa);
    if (!tracer) return tracer.error();
    context->tracer = std::move(*tracer);
    return std::shared_ptr<const SceneContext>(std::move(context));
}

Result<std::shared_ptr<const PlanContext>> make_plan_context(std::span<const std::byte> plan_bytes) {
    auto plan = decode_plan(plan_bytes);
    if (!plan) return plan.error();
    auto emission = make_emission(plan->palette.scene);
    if (!emission) return emission.error();
    return std::shared_ptr<const PlanContext>(std::make_shared<PlanContext>(std::move(*plan), std::move(*emission)));
}

namespace {

Result<TexelLayout> layout_of(const ScenePlan& plan) {
    const auto& first = plan.first_triangle;
    std::vector<std::uint32_t> surfaces;
    for (std::uint32_t surface = 0; surface + 1 < first.size(); ++surface) surfaces.resize(first[surface + 1], surface);
    return TexelLayout::of_rows(plan.texel_rows, surfaces, first.size() - 1);
}

}  // namespace

Result<std::shared_ptr<const JobContext>> make_job_context(const wire::JobInfo& info,
                                                           std::shared_ptr<const SceneContext> scene,
                                                           std::shared_ptr<const PlanContext> plan) {
    if (const auto good = validate(info.spec); !good) return good.error();
    auto context = std::make_shared<JobContext>();
    context->job = info.job;
    context->spec = info.spec;
    context->scene = std::move(scene);
    context->plan = std::move(plan);
    if (info.spec.packing == Packing::maps) {
        if (context->plan && context->plan->plan.texel_rows.empty()) return bad_input("the plan has no texels");
        auto layout =
            context->plan ? layout_of(context->plan->plan) : TexelLayout::make(context->scene->scene, info.texel_m);
        if (!layout) return layout.error();
        context->layout = std::move(*layout);
    }
    return std::shared_ptr<const JobContext>(std::move(context));
}

JobMaker tracing_jobs(const std::string& isa, const TracerMaker& make_tracer) {
    return [=, name = Digest(), last = std::weak_ptr<const SceneContext>()](
               const wire::JobInfo& info,
               std::span<const std::byte> file) mutable -> Result<std::shared_ptr<const JobContext>> {
        if (info.spec.strategy == Strategy::subspaces) {
            auto plan = make_plan_context(file);
            if (!plan) return plan.error();
            return make_job_context(info, nullptr, std::move(*plan));
        }
        auto scene = name == info.scene ? last.lock() : nullptr;
        if (!scene) {
            auto made = make_scene_context(file, isa, make_tracer);
            if (!made) return made.error();
            scene = std::move(*made);
            last = scene;
            name = info.scene;
        }
        return make_job_context(info, std::move(scene), nullptr);
    };
}

}  // namespace lumenfarm
