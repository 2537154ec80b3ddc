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

Result<std::shared_ptr<const JobContext>> make_job_context(const wire::JobInfo& info,
                                                           std::shared_ptr<const SceneContext> scene) {
    if (const auto good = validate(info.spec); !good) return good.error();
    auto context = std::make_shared<JobContext>();
    context->job = info.job;
    context->spec = info.spec;
    context->scene = std::move(scene);
    if (info.spec.packing == Packing::maps) {
        auto layout = TexelLayout::make(context->scene->scene, info.texel_m);
        if (!layout) return layout.error();
        context->layout = std::move(*layout);
    }
    return std::shared_ptr<const JobContext>(std::move(context));
}

}  // namespace lumenfarm
