#pragma once

#include "common/scene/job_spec.h"
#include "common/scene/scene.h"
#include "common/solution/solution.h"
#include "common/solution/texel_layout.h"
#include "common/support/result.h"
#include "common/transport/emitter.h"
#include "common/transport/part_tracer.h"
#include "common/transport/scene_plan.h"
#include "common/transport/tracer.h"
#include "proto/messages.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

/// What a tracing thread needs of a job. Read-only and shared by threads.
namespace lumenfarm {

using JobId = std::uint64_t;

/// A compiled scene made ready for tracing. Jobs of one scene share it.
struct SceneContext {
    Scene scene;
    std::unique_ptr<TracerScene> tracer;  ///< over `scene`
};

/// What the object-space strategy knows of a scene beside the parts that are at hand.
struct PlanContext {
    PlanContext(ScenePlan plan_, Emission emission_)
        : plan(std::move(plan_)),
          emission(std::move(emission_)),
          emitter(plan.palette, emission, plan.partition, plan.extent) {}
    PlanContext(const PlanContext&) = delete;
    PlanContext& operator=(const PlanContext&) = delete;

    const ScenePlan plan;
    const Emission emission;
    const Emitter emitter;
};

struct JobContext {
    JobId job = 0;
    JobSpec spec;                               ///< its packing is the one in force
    std::shared_ptr<const SceneContext> scene;  ///< strategy sets
    std::shared_ptr<const PlanContext> plan;    ///< strategy subspaces
    std::optional<TexelLayout> layout;          ///< packing maps

    const Emission& emission() const { return plan ? plan->emission : scene->tracer->emission(); }
    std::uint32_t lights() const { return static_cast<std::uint32_t>(emission().lights.size()); }
    /// REQUIRES: packing maps.
    LightMap empty_map() const { return LightMap(*layout); }
};

/// Errors: bad_input (damaged scene), failed (no memory for the tracer). `isa` as in TracerScene::make.
Result<std::shared_ptr<const SceneContext>> make_scene_context(std::span<const std::byte> scene_bytes,
                                                               const std::string& isa, const TracerMaker& make_tracer);
/// Errors: bad_input (damaged plan).
Result<std::shared_ptr<const PlanContext>> make_plan_context(std::span<const std::byte> plan_bytes);

/// One of the two, as the strategy asks. Errors: bad_input (a spec that can't be, too many texels).
Result<std::shared_ptr<const JobContext>> make_job_context(const wire::JobInfo& info,
                                                           std::shared_ptr<const SceneContext> scene,
                                                           std::shared_ptr<const PlanContext> plan);

/// From the file that a master names: the compiled scene, or with strategy subspaces the plan. Errors: bad_input,
/// failed.
using JobMaker = std::function<Result<std::shared_ptr<const JobContext>>(const wire::JobInfo& info,
                                                                         std::span<const std::byte> file)>;

/// One that lets jobs of one scene share it. `isa` as in TracerScene::make. Not for several threads at once.
JobMaker tracing_jobs(const std::string& isa, const TracerMaker& make_tracer = &TracerScene::make);

}  // namespace lumenfarm
